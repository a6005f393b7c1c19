# Warnings are errors in our own code. clang++, which builds for the sanitizers, counts signs among conversions.
add_library(recede_warnings INTERFACE)
target_compile_options(recede_warnings INTERFACE -Wall -Wextra -Wshadow -Wconversion -Wsign-conversion -Werror
  # g++ 12 takes inlined Eigen vectors for uninitialised; the sanitizer build looks for the real thing.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)

# recede_room(name LINK targets... PRIVATE targets... SOURCES files...)
# One library for one room, with the room's headers, its alias recede::name and its install rules.
function(recede_room name)
  cmake_parse_arguments(room "" "" "LINK;PRIVATE;SOURCES" ${ARGN})
  add_library(recede_${name} STATIC ${room_SOURCES})
  add_library(recede::${name} ALIAS recede_${name})
  set_target_properties(recede_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(recede_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(recede_${name} PUBLIC cxx_std_20)
  # Results must not depend on whether a compiler fuses a multiplication and an addition.
  target_compile_options(recede_${name} PRIVATE -ffp-contract=off)
  target_link_libraries(recede_${name} PUBLIC ${room_LINK} PRIVATE ${room_PRIVATE} $<BUILD_INTERFACE:recede_warnings>)
  install(TARGETS recede_${name} EXPORT recedeTargets)
  install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/recede/${name}
    FILES_MATCHING PATTERN "*.h" PATTERN "detail" EXCLUDE PATTERN "cgal" EXCLUDE)
endfunction()
