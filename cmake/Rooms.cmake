# kinetostat_room(NAME SOURCES a.cpp ... [PUBLIC lib ...] [PRIVATE lib ...] [LIGHT])
#
# A room is a folder, a namespace and one static library: kinetostat::NAME. Its headers lie beside its sources. A LIGHT
# one reads, writes and formats, and is compiled quickly instead of running quickly.
function(kinetostat_room name)
  cmake_parse_arguments(ROOM "LIGHT" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  set(target kinetostat_${name})
  add_library(${target} STATIC ${ROOM_SOURCES})
  add_library(kinetostat::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${KINETOSTAT_INCLUDE_DIR}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_link_libraries(${target}
    PUBLIC ${ROOM_PUBLIC}
    PRIVATE ${ROOM_PRIVATE} $<BUILD_INTERFACE:kinetostat_settings>)
  if(ROOM_LIGHT)
    target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:kinetostat_light>)
    kinetostat_use_precompiled(${target} kinetostat_parsed_light)
  else()
    kinetostat_use_precompiled(${target} kinetostat_parsed)
  endif()
  kinetostat_unity(${target} 12)
  install(TARGETS ${target} EXPORT kinetostat ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
    COMPONENT development)
  install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kinetostat/${name}
    COMPONENT development FILES_MATCHING PATTERN "*.h")
endfunction()
