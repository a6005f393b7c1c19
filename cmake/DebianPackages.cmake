# Packages for Debian: `cpack -G DEB` in the build folder, or `./dev package`. Three of them: who runs the command needs no
# Python, and the libraries need development packages of hundreds of megabytes.
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "The Recede authors <recede@example.invalid>")
# Descriptions of components begin with summaries of their own.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_COMPONENTS_ALL command development)

set(about "
Recede takes a mesh and makes a hierarchy of coarser levels; each carries its
measured error, a certified bound of it, and the distance from which on it may
stand in for the original.
.
")

set(CPACK_DEBIAN_COMMAND_PACKAGE_NAME recede)
set(CPACK_DEBIAN_COMMAND_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_COMMAND_DESCRIPTION
  "level-of-detail geometry that says how wrong it is${about}This package has the command.")

# What recedeConfig.cmake finds, and what its targets link.
set(libraries libeigen3-dev libembree-dev libfast-float-dev libfmt-dev libopenexr-dev libopenmesh-dev libosd-dev libpng-dev libjpeg-dev
  libtbb-dev libzstd-dev nlohmann-json3-dev zlib1g-dev)
if(RECEDE_CAD)
  # Debian's files for OpenCASCADE ask the linker for fontconfig, which they don't depend on.
  list(APPEND libraries libfontconfig-dev libocct-data-exchange-dev libocct-ocaf-dev)
endif()
if(RECEDE_CGAL_GPL)
  list(APPEND libraries libgmp-dev libmpfr-dev)
endif()
list(JOIN libraries ", " CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME librecede-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION
  "level-of-detail geometry that says how wrong it is (C++)${about}This package has headers, static libraries, and what find_package(recede) needs.")

if(RECEDE_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python_debian)
  # The compiled part serves one version of Python.
  math(EXPR next_minor "${Python3_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_DEBIAN_PACKAGE_DEPENDS
    "python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next_minor}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_DEBIAN_PACKAGE_NAME python3-recede)
  set(CPACK_DEBIAN_PYTHON_DEBIAN_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_DEBIAN_PACKAGE_CONTROL_EXTRA
    ${PROJECT_SOURCE_DIR}/cmake/debian/postinst ${PROJECT_SOURCE_DIR}/cmake/debian/prerm)
  set(CPACK_DEBIAN_PYTHON_DEBIAN_DESCRIPTION
    "level-of-detail geometry that says how wrong it is (Python)${about}This package has the module recede, with numpy arrays in and out.")
endif()

# Each package says what it may be used for; what contains CGAL's parts is under the GPL as a whole.
file(READ LICENSE license)
if(RECEDE_CGAL_GPL)
  string(APPEND license "
This build contains CGAL's package alpha_wrap_3 (Copyright (c) 2019-2022 Google LLC and others), which is under the
GNU General Public License, version 3 or later, and may be passed on under that licence only: see
/usr/share/common-licenses/GPL-3.
")
endif()
if(RECEDE_VIEWER)
  file(READ ${RECEDE_VIEWER_MODULES}/node_modules/three/LICENSE license_of_three)
  string(APPEND license "
This build contains three.js, for the viewer in reports:

${license_of_three}")
endif()
file(WRITE ${PROJECT_BINARY_DIR}/copyright "${license}")
foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} upper)
  install(FILES ${PROJECT_BINARY_DIR}/copyright DESTINATION share/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME}
    COMPONENT ${component} EXCLUDE_FROM_ALL)
endforeach()

include(CPack)
