# Debian packages by CPack, one for each component (scripts/package). What each is linked with, dpkg-shlibdeps finds.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME kinetostat)
set(CPACK_PACKAGE_CONTACT "kinetostat maintainers <maintainers@users.noreply.h-seed-6e15f37c.example>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL "")
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each has its own
set(what "kinetostat computes the stiffness of robots and machine tools from the CAD
meshes of their links, by finite elements and the virtual joint method,
compares it with measurements, and says which physical effect (backlash,
friction, a soft base) the model lacks.")

# kinetostat_package(COMPONENT NAME DESCRIPTION): the licence and the changelog come along.
macro(kinetostat_package component name description)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "${description}")
  foreach(file ${PROJECT_SOURCE_DIR}/packaging/copyright ${PROJECT_BINARY_DIR}/manual/changelog.gz
      ${PROJECT_BINARY_DIR}/manual/changelog.Debian.gz)
    install(FILES ${file} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component})
  endforeach()
endmacro()

# CHOLMOD is satisfied with any BLAS, and the reference one is ten times slower.
kinetostat_package(program kinetostat "stiffness of robots and machine tools\n${what}\n\nThe program, its data and its man pages.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "libopenblas0-pthread")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "gmsh, kinetostat-petsc, kinetostat-step")

if(TARGET kinetostat-petsc)
  kinetostat_package(petsc kinetostat-petsc
    "stiffness of robots and machine tools, largest models\n${what}\n\nThe helper that solves the largest models by PETSc.")
  set(CPACK_DEBIAN_PETSC_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PETSC_PACKAGE_DEPENDS "kinetostat (= ${PROJECT_VERSION}-1)")
endif()

if(TARGET kinetostat-step)
  kinetostat_package(step kinetostat-step
    "stiffness of robots and machine tools, STEP files\n${what}\n\nThe helper that reads STEP files by Open CASCADE.")
  set(CPACK_DEBIAN_STEP_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_STEP_PACKAGE_DEPENDS "kinetostat (= ${PROJECT_VERSION}-1)")
endif()

if(TARGET kinetostat_python)
  kinetostat_package(python python3-kinetostat
    "stiffness of robots and machine tools, Python module\n${what}\n\nThe package kinetostat of Debian's Python.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "libopenblas0-pthread, python3 (>= 3.11), python3 (<< 3.12), python3-numpy (>= 1:1.24)")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "kinetostat, python3-pandas, python3-matplotlib, python3-distributed")
endif()

kinetostat_package(development libkinetostat-dev
  "stiffness of robots and machine tools, library\n${what}\n\nHeaders, static libraries and the files of find_package(kinetostat).")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
string(CONCAT CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libassimp-dev, libeigen3-dev, libfmt-dev, libmd-dev, libmetis-dev, libopenblas0-pthread, libsuitesparse-dev, "
  "libtinyxml2-dev, libyaml-cpp-dev, nlohmann-json3-dev, zlib1g-dev")

include(CPack)
