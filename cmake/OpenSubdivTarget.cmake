# OpenSubdiv::osdCPU. Debian's package of OpenSubdiv configures for static libraries that it doesn't ship, so
# find_package fails; this serves the build and, installed, projects that find Recede.
if(NOT TARGET OpenSubdiv::osdCPU)
  find_path(OPENSUBDIV_INCLUDE_DIR opensubdiv/version.h REQUIRED)
  find_library(OPENSUBDIV_CPU_LIBRARY osdCPU REQUIRED)
  add_library(OpenSubdiv::osdCPU UNKNOWN IMPORTED)
  set_target_properties(OpenSubdiv::osdCPU PROPERTIES
    IMPORTED_LOCATION ${OPENSUBDIV_CPU_LIBRARY} INTERFACE_INCLUDE_DIRECTORIES ${OPENSUBDIV_INCLUDE_DIR})
endif()
