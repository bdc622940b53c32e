# Compiler settings shared by every target.
include(GNUInstallDirs)
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # packages need the program, and not all that tests do

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

# One spelling of every header, in this tree and when installed: #include "kinetostat/<module>/<sub-module>/<idea>.h".
set(KINETOSTAT_INCLUDE_DIR ${PROJECT_BINARY_DIR}/include)
file(MAKE_DIRECTORY ${KINETOSTAT_INCLUDE_DIR})
file(CREATE_LINK ${PROJECT_SOURCE_DIR} ${KINETOSTAT_INCLUDE_DIR}/kinetostat SYMBOLIC)

add_library(kinetostat_settings INTERFACE)
target_compile_features(kinetostat_settings INTERFACE cxx_std_20)
# Contracting a*b+c differs between compilers and machines; the printed tables must not.
target_compile_options(kinetostat_settings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -ffp-contract=off
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)  # GCC 12 warns wrongly about std::string (its bug 105651)
if(KINETOSTAT_STRICT)
  target_compile_options(kinetostat_settings INTERFACE -Werror)
  target_compile_definitions(kinetostat_settings INTERFACE _GLIBCXX_ASSERTIONS)
endif()
