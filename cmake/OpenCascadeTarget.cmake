# recede::opencascade: what reading CAD files links, where it is installed; for the build and, installed, for projects that
# find Recede. Its own targets don't say where its headers are.
if(NOT TARGET recede::opencascade)
  # Without a version: its file accepts the exact one only. Data exchange links to parts of Visualization.
  # It also sets definitions for everything in the folder.
  get_directory_property(definitions_before COMPILE_DEFINITIONS)
  find_package(OpenCASCADE QUIET CONFIG
    COMPONENTS FoundationClasses ModelingData ModelingAlgorithms Visualization ApplicationFramework DataExchange)
  set_directory_properties(PROPERTIES COMPILE_DEFINITIONS "${definitions_before}")
  if(OpenCASCADE_FOUND)
    add_library(recede::opencascade INTERFACE IMPORTED)
    set_target_properties(recede::opencascade PROPERTIES
      INTERFACE_INCLUDE_DIRECTORIES ${OpenCASCADE_INCLUDE_DIR}
      INTERFACE_LINK_LIBRARIES
        "TKXDESTEP;TKXDEIGES;TKXCAF;TKSTEP;TKIGES;TKXSBase;TKLCAF;TKCDF;TKShHealing;TKTopAlgo;TKGeomAlgo;TKBRep;TKGeomBase;TKG3d;TKG2d;TKMath;TKernel")
  endif()
endif()
