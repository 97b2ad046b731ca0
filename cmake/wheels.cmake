# SPDX-License-Identifier: Apache-2.0
# Libraries that come as Python wheels: Pinocchio with Coal, Eigen and Boost headers, MuJoCo.
# They are searched on sys.path, because an isolated build puts them in an overlay that sysconfig does not know.
if(ROBOTSKIN_PYTHON)
  find_package(Python 3.11 REQUIRED COMPONENTS Interpreter Development.Module)
else()
  find_package(Python 3.11 REQUIRED COMPONENTS Interpreter)
endif()

execute_process(
  COMMAND "${Python_EXECUTABLE}" -c
    "import sys,pathlib;print(';'.join(dict.fromkeys(str(pathlib.Path(p)/'cmeel.prefix') for p in sys.path if (pathlib.Path(p)/'cmeel.prefix/lib/cmake').is_dir())))"
  OUTPUT_STRIP_TRAILING_WHITESPACE OUTPUT_VARIABLE CMEEL_PREFIX COMMAND_ERROR_IS_FATAL ANY)
list(PREPEND CMAKE_PREFIX_PATH ${CMEEL_PREFIX})

find_package(pinocchio 4.1 REQUIRED CONFIG)
find_package(coal 3.0 REQUIRED CONFIG)
find_package(Boost REQUIRED CONFIG)

execute_process(
  COMMAND "${Python_EXECUTABLE}" -c
    "import importlib.util,pathlib;print(pathlib.Path(importlib.util.find_spec('mujoco').origin).parent)"
  OUTPUT_STRIP_TRAILING_WHITESPACE OUTPUT_VARIABLE MUJOCO_DIR COMMAND_ERROR_IS_FATAL ANY)
file(GLOB MUJOCO_LIBRARY "${MUJOCO_DIR}/libmujoco.so.*")
add_library(mujoco::mujoco SHARED IMPORTED GLOBAL)
set_target_properties(mujoco::mujoco PROPERTIES
  IMPORTED_LOCATION "${MUJOCO_LIBRARY}" INTERFACE_INCLUDE_DIRECTORIES "${MUJOCO_DIR}/include")
