# SPDX-License-Identifier: Apache-2.0
# The list of the kinds of faults, made of the files that define them: core/world/network/faults/NAME.cpp defines
# `NAME`. It lies in the folder that the variable `fault_list_folder` then names.
set(fault_list_folder ${CMAKE_CURRENT_BINARY_DIR}/generated)
file(GLOB fault_files CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/../core/world/network/faults/*.cpp)
set(fault_list "")
foreach(file ${fault_files})
  get_filename_component(name ${file} NAME_WE)
  string(APPEND fault_list "ROBOTSKIN_FAULT(${name})\n")
endforeach()
file(CONFIGURE OUTPUT ${fault_list_folder}/world/network/fault_list.inc CONTENT "${fault_list}" @ONLY)
