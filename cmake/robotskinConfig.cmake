# SPDX-License-Identifier: Apache-2.0
# find_package(robotskin CONFIG) gives the target robotskin::robotskin.
# Pinocchio, Coal and Boost may come with the system, or as the wheels of the Python interpreter that is found first.
include(CMakeFindDependencyMacro)
if(NOT TARGET pinocchio::pinocchio_default)
  find_package(Python COMPONENTS Interpreter)
  if(Python_FOUND)
    execute_process(
      COMMAND "${Python_EXECUTABLE}" -c
        "import sys,pathlib;print(';'.join(str(p) for p in (pathlib.Path(f)/'cmeel.prefix' for f in sys.path) if (p/'lib/cmake').is_dir()))"
      OUTPUT_STRIP_TRAILING_WHITESPACE OUTPUT_VARIABLE robotskin_wheels)
    list(APPEND CMAKE_PREFIX_PATH ${robotskin_wheels})
  endif()
endif()
find_dependency(pinocchio 4.1 CONFIG)
find_dependency(coal 3.0 CONFIG)
find_dependency(Boost CONFIG)
include("${CMAKE_CURRENT_LIST_DIR}/robotskinTargets.cmake")
