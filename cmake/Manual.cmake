# What the program says of itself, for packages: man pages and completions, made by running it.
set(manual ${PROJECT_BINARY_DIR}/manual)
add_custom_command(OUTPUT ${manual}/made
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${manual}
  COMMAND kinetostat --manual ${manual}/man1
  COMMAND gzip -9n ${manual}/man1/kinetostat*.1
  COMMAND kinetostat --completion bash > ${manual}/kinetostat
  COMMAND kinetostat --completion zsh > ${manual}/_kinetostat
  COMMAND kinetostat --completion fish > ${manual}/kinetostat.fish
  COMMAND gzip -9nc ${PROJECT_SOURCE_DIR}/CHANGELOG.md > ${manual}/changelog.gz
  COMMAND gzip -9nc ${PROJECT_SOURCE_DIR}/packaging/changelog.Debian > ${manual}/changelog.Debian.gz
  COMMAND ${CMAKE_COMMAND} -E touch ${manual}/made
  DEPENDS kinetostat ${PROJECT_SOURCE_DIR}/CHANGELOG.md ${PROJECT_SOURCE_DIR}/packaging/changelog.Debian
  COMMENT "Man pages and completions")
add_custom_target(kinetostat-manual ALL DEPENDS ${manual}/made)

install(DIRECTORY ${manual}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT program)
install(FILES ${manual}/kinetostat DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT program)
install(FILES ${manual}/_kinetostat DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT program)
install(FILES ${manual}/kinetostat.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d
  COMPONENT program)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/kinetostat COMPONENT program
  FILES_MATCHING PATTERN "*.md" PATTERN "*.png" PATTERN "*.svg")
