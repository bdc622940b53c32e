# What compiling costs, second half: sources of one folder are compiled together, so that what they all instantiate is
# instantiated once. The presets for developers have each source for itself: a change compiles one file, and each shows
# that it names what it needs.
option(KINETOSTAT_UNITY "Compile the sources of a folder together" ON)
if(KINETOSTAT_UNITY)
  # Warnings about names of one source that another one sees, and false ones of GCC 12.
  target_compile_options(kinetostat_settings INTERFACE -Wno-shadow
    $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage;-Wno-free-nonheap-object;-Wno-maybe-uninitialized>)
endif()

# kinetostat_unity(TARGET MOST): the sources of each folder in batches of MOST or fewer, as equal as can be. Sources that
# use the same short names have a namespace of their own.
function(kinetostat_unity target most)
  if(NOT KINETOSTAT_UNITY)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  set(folders "")
  foreach(source IN LISTS sources)
    get_filename_component(folder ${source} DIRECTORY)
    string(MAKE_C_IDENTIFIER "in_${folder}" folder)
    list(APPEND folders ${folder})
    list(APPEND ${folder} ${source})
  endforeach()
  list(REMOVE_DUPLICATES folders)
  foreach(folder IN LISTS folders)
    list(LENGTH ${folder} count)
    math(EXPR batches "(${count} + ${most} - 1) / ${most}")
    set(at 0)
    foreach(source IN LISTS ${folder})
      math(EXPR batch "${at} * ${batches} / ${count}")
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${folder}_${batch})
      math(EXPR at "${at} + 1")
    endforeach()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
