# SPDX-License-Identifier: Apache-2.0
"""Applications: one folder each, built from public names alone; `robotskin app` lists them.

A folder `NAME/` has the files that it needs of these:

- `__init__.py`: the first line of its docstring is the line in the list;
- `command.py`: the function `command`, whose arguments become options of `robotskin app NAME`, `--headless` among them;
- `states.py`: its states and what leads from one to the next; `tasks.py`: the tasks and behaviours that it adds;
- `scene.toml`: the things around the robot;
- `script.py`: the headless run, its figures and their bounds (`robotskin.figures`);
- `panel.py`: its part of the page, the one file that may import the viewer.

Options that several have, such as `--seed`, stand once in `options.py`.
"""

import pkgutil


def names() -> list[str]:
    """The applications, by alphabet."""
    return sorted(module.name for module in pkgutil.iter_modules(__path__) if module.ispkg)
