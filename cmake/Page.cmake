# kinetostat_page(VARIABLE)
#
# Sets VARIABLE to the file of the page that results are put into: our style and script, and Plotly, which
# npm fetches as report/page/package-lock.json pins it. Without npm the file is empty, and that is said.
function(kinetostat_page variable)
  set(source ${PROJECT_SOURCE_DIR}/report/page)
  set(work ${PROJECT_BINARY_DIR}/page)
  set(page ${work}/page.html)
  set(plotly ${work}/node_modules/plotly.js-strict-dist-min/plotly-strict.min.js)
  set(${variable} ${page} PARENT_SCOPE)
  file(MAKE_DIRECTORY ${work})
  find_program(NPM npm)
  find_program(NODE NAMES node nodejs)
  file(SHA256 ${source}/package-lock.json pinned)
  set(fetched "")
  if(EXISTS ${plotly} AND EXISTS ${work}/fetched)
    file(READ ${work}/fetched fetched)
  endif()
  if(NPM AND NODE AND NOT fetched STREQUAL pinned)
    file(COPY ${source}/package.json ${source}/package-lock.json DESTINATION ${work})
    execute_process(COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund
      WORKING_DIRECTORY ${work} TIMEOUT 300 RESULT_VARIABLE failed OUTPUT_QUIET ERROR_VARIABLE errors)
    if(failed)
      message(WARNING "npm could not fetch Plotly, so --html will not work: ${errors}")
    else()
      file(WRITE ${work}/fetched ${pinned})
      set(fetched ${pinned})
    endif()
  endif()
  if(NOT NPM OR NOT NODE)
    message(STATUS "npm is not installed: results cannot be written as HTML pages")
  endif()
  if(NOT fetched STREQUAL pinned)
    file(WRITE ${page} "")
    return()
  endif()
  if(EXISTS ${page})
    file(SIZE ${page} size)
    if(size EQUAL 0)  # left by a configuration without npm
      file(REMOVE ${page})
    endif()
  endif()
  file(GLOB parts CONFIGURE_DEPENDS ${source}/*.js ${source}/*.css ${source}/*.html ${source}/*.mjs
    ${source}/sections/*.js ${source}/studio/*.js ${source}/studio/*.css
    ${PROJECT_SOURCE_DIR}/docs/reference/glossary.md)
  add_custom_command(OUTPUT ${page}
    COMMAND ${NODE} ${source}/bundle.mjs ${plotly} ${page}
    DEPENDS ${parts} ${plotly} COMMENT "Bundling the page" VERBATIM)
endfunction()
