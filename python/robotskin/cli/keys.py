# SPDX-License-Identifier: Apache-2.0
"""`robotskin keys`: the secret of a skin of hardware."""

from pathlib import Path
from typing import Annotated

import typer


def command(
    file: Annotated[Path, typer.Argument(help="Where to write them; only you may read it.", dir_okay=False)],
    replace: Annotated[bool, typer.Option("--replace", help="Make new ones where there are some.")] = False,
) -> None:
    """Make the keys of a skin: a file that section units and host read, and from which each cell's keys come.

    A simulation needs none: it draws its own. Keep the file: cells that have its keys obey no others.
    """
    from robotskin.keys import SkinKeys
    from robotskin.outputs import require_writable

    require_writable("keys", file)
    SkinKeys.fresh().save(file, replace=replace)
    typer.echo(f"Wrote {file} (mode 0600).")
