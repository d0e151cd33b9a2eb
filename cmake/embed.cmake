# isthmus_embed(NAME FUNCTION function [FOLDER folder] [DEPENDS files and targets...]): a library with
# all files of a folder in it, which isthmus::FUNCTION returns (core/asset.h). The folder
# may come to be while building: it is read when one of DEPENDS has changed.
function(isthmus_embed name)
  cmake_parse_arguments(ARG "" "FUNCTION;FOLDER" "DEPENDS" ${ARGN})
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${name}.cc)
  add_custom_command(
    OUTPUT ${source}
    COMMAND ${ISTHMUS_PYTHON} ${PROJECT_SOURCE_DIR}/cmake/embed.py ${source} ${ARG_FUNCTION}
            "${ARG_FOLDER}"
    DEPENDS ${PROJECT_SOURCE_DIR}/cmake/embed.py ${ARG_DEPENDS}
    COMMENT "Taking ${ARG_FOLDER} into ${name}"
    VERBATIM)
  add_library(${name} STATIC ${source})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE absl::strings)
endfunction()
