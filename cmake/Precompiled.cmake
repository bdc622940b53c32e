# What compiling costs: headers that nearly every unit parses are parsed once, and units that compute nothing are not
# optimised as those that do. The presets for developers have no precompiled headers: there each unit shows that it
# names the headers it needs.
option(KINETOSTAT_PRECOMPILED_HEADERS "Parse headers of the standard library, Eigen and fmt once" ON)

find_package(Eigen3 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(Threads REQUIRED)

# Text, files, pages, commands, tests.
add_library(kinetostat_light INTERFACE)
target_compile_options(kinetostat_light INTERFACE $<$<CONFIG:Release>:-O1>)

set(KINETOSTAT_COMMON_HEADERS
  <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <limits> <map> <memory> <numbers> <numeric> <optional>
  <set> <stdexcept> <string> <string_view> <utility> <variant> <vector> <Eigen/Dense> <fmt/format.h> <fmt/ranges.h>)

# A target that does nothing but parse headers for others that are compiled with the same options.
function(kinetostat_precompiled name)
  cmake_parse_arguments(PARSED "" "" "HEADERS;LINK" ${ARGN})
  set(source ${PROJECT_BINARY_DIR}/precompiled/${name}.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "// Nothing: the headers are all there is.\n")
  add_library(${name} OBJECT EXCLUDE_FROM_ALL ${source})
  target_link_libraries(${name} PRIVATE kinetostat_settings Threads::Threads Eigen3::Eigen fmt::fmt ${PARSED_LINK})
  target_precompile_headers(${name} PRIVATE ${KINETOSTAT_COMMON_HEADERS} ${PARSED_HEADERS})
endfunction()

if(KINETOSTAT_PRECOMPILED_HEADERS)
  # GCC looks for garbage when its memory has grown by a third, which is a seventh of its time: it may keep 1.5 GB first.
  target_compile_options(kinetostat_settings INTERFACE
    "$<$<CXX_COMPILER_ID:GNU>:SHELL:--param ggc-min-expand=100 --param ggc-min-heapsize=1500000>")
  # GCC 12 forgets that std::string is a system header, and warns wrongly about it (its bugs 105329, 105651).
  target_compile_options(kinetostat_settings INTERFACE
    $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow;-Wno-stringop-overread;-Wno-array-bounds>)
  kinetostat_precompiled(kinetostat_parsed)
  kinetostat_precompiled(kinetostat_parsed_light HEADERS <nlohmann/json.hpp>
    LINK kinetostat_light nlohmann_json::nlohmann_json)
endif()

# kinetostat_use_precompiled(TARGET DONOR): where there are any.
function(kinetostat_use_precompiled target donor)
  if(KINETOSTAT_PRECOMPILED_HEADERS)
    target_precompile_headers(${target} REUSE_FROM ${donor})
    target_compile_definitions(${target} PRIVATE $<TARGET_PROPERTY:fmt::fmt,INTERFACE_COMPILE_DEFINITIONS>)
    get_target_property(type ${target} TYPE)
    if(type STREQUAL EXECUTABLE)  # compiled as the donor is, whose code goes into libraries, too
      set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
      target_compile_options(${target} PRIVATE -fPIC)
    endif()
  endif()
endfunction()
