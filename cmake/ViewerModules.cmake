# What the report's viewer is made of: npm's packages of render/viewer/package-lock.json, fetched once into
# RECEDE_VIEWER_MODULES. Where that fails, the library is built without the viewer.
find_program(RECEDE_NODE node)
find_program(RECEDE_NPM npm)
mark_as_advanced(RECEDE_NODE RECEDE_NPM)
set(viewer_lock ${PROJECT_SOURCE_DIR}/render/viewer/package-lock.json)
set(viewer_fetched ${RECEDE_VIEWER_MODULES}/fetched)
set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${viewer_lock})

file(SHA256 ${viewer_lock} wanted)
set(present "")
if(EXISTS ${viewer_fetched})
  file(READ ${viewer_fetched} present)
endif()
if(RECEDE_NODE AND RECEDE_NPM AND NOT present STREQUAL wanted)
  message(STATUS "Fetching npm packages for the report's viewer")
  file(COPY ${PROJECT_SOURCE_DIR}/render/viewer/package.json ${viewer_lock} DESTINATION ${RECEDE_VIEWER_MODULES})
  execute_process(
    COMMAND ${RECEDE_NPM} ci --silent --ignore-scripts --no-fund --no-audit --prefer-offline --fetch-retries=1
    WORKING_DIRECTORY ${RECEDE_VIEWER_MODULES} RESULT_VARIABLE failure TIMEOUT 300)
  if(failure EQUAL 0)
    file(WRITE ${viewer_fetched} ${wanted})
    set(present ${wanted})
  endif()
endif()
if(NOT RECEDE_NODE OR NOT present STREQUAL wanted)
  message(STATUS "No npm, or no network for it: built without the report's viewer")
  set(RECEDE_VIEWER OFF)
endif()
