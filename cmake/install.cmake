# SPDX-License-Identifier: Apache-2.0
# What a C++ program needs of robotskin: cmake --install BUILD --prefix PREFIX --component cpp; no wheel holds it.
# Headers stand below include/robotskin/, a folder a stage, and include each other by that name.
set(robotskin_stages model driver skin record control robot loop ur)
set(robotskin_libraries robotskin_firmware)
foreach(stage ${robotskin_stages})
  list(APPEND robotskin_libraries robotskin_${stage})
  # The sources say "control/task.hpp"; installed headers must not claim such names from those of other projects.
  install(CODE "
    file(GLOB headers RELATIVE \"${PROJECT_SOURCE_DIR}/core\" \"${PROJECT_SOURCE_DIR}/core/${stage}/*.hpp\")
    string(REPLACE \";\" \"|\" folders \"${robotskin_stages}\")
    foreach(header \${headers})
      file(READ \"${PROJECT_SOURCE_DIR}/core/\${header}\" text)
      string(REGEX REPLACE \"#include \\\"(\${folders})/\" \"#include \\\"robotskin/\\\\1/\" text \"\${text}\")
      file(WRITE \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/include/robotskin/\${header}\" \"\${text}\")
    endforeach()" COMPONENT cpp)
endforeach()
install(DIRECTORY firmware/include/robotskin DESTINATION include COMPONENT cpp FILES_MATCHING PATTERN "*.h")

add_library(robotskin INTERFACE)
target_link_libraries(robotskin INTERFACE ${robotskin_libraries})
target_compile_features(robotskin INTERFACE cxx_std_20)
target_include_directories(robotskin INTERFACE $<INSTALL_INTERFACE:include>)
install(TARGETS robotskin ${robotskin_libraries} EXPORT robotskin COMPONENT cpp
  ARCHIVE DESTINATION lib COMPONENT cpp)
install(EXPORT robotskin NAMESPACE robotskin:: FILE robotskinTargets.cmake
  DESTINATION lib/cmake/robotskin COMPONENT cpp)

include(CMakePackageConfigHelpers)
write_basic_package_version_file(robotskinConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES cmake/robotskinConfig.cmake "${CMAKE_CURRENT_BINARY_DIR}/robotskinConfigVersion.cmake"
  DESTINATION lib/cmake/robotskin COMPONENT cpp)
