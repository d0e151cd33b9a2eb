# Writes manual pages of the --help of the programs of WHAT, a component, found in BIN, to OUTPUT.
# Which commands there are is read from their help.
cmake_minimum_required(VERSION 3.25)
file(REMOVE_RECURSE "${OUTPUT}")

function(help_of output)
  execute_process(COMMAND ${ARGN} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
  set(${output} "${help}" PARENT_SCOPE)
endfunction()

# The names below the heading of a help, up to the next blank line.
function(names_below output heading help)
  set(names)
  if("${help}" MATCHES "\n${heading}:\n(([^\n]+\n)+)")
    string(REGEX MATCHALL "\n  [a-z]+" names "\n${CMAKE_MATCH_1}")
    list(TRANSFORM names STRIP)
  endif()
  set(${output} ${names} PARENT_SCOPE)
endfunction()

# page(SECTION PROGRAM [WORD ...]): of `isthmus anchor set --help` makes isthmus-anchor-set.1; for
# a command also the pages of the commands below it.
function(page section program)
  list(SUBLIST ARGV 1 -1 name)
  list(JOIN name "-" name)
  list(JOIN ARGN " " command)
  help_of(help ${BIN}/${program} ${ARGN})
  string(REGEX MATCH "[^\n]+" summary "${help}")
  string(REGEX REPLACE "\\.$" "" summary "${summary}")
  # help2man takes the page's name from the program's.
  file(MAKE_DIRECTORY "${OUTPUT}/man${section}")
  file(CREATE_LINK ${BIN}/${program} "${OUTPUT}/${name}" SYMBOLIC)
  execute_process(
    COMMAND ${HELP2MAN} --no-info --include=${INCLUDE} --section=${section} --source=Isthmus "--name=${summary}"
            --version-string=${VERSION} "--help-option=${command} --help"
            --output=${OUTPUT}/man${section}/${name}.${section} ${OUTPUT}/${name}
    COMMAND_ERROR_IS_FATAL ANY)
  file(REMOVE "${OUTPUT}/${name}")
  names_below(below "Subcommands" "${help}")
  if(ARGN)
    foreach(next ${below})
      page(${section} ${program} ${ARGN} ${next})
    endforeach()
  endif()
endfunction()

if(WHAT STREQUAL "server")
  page(8 isthmus-server)
else()
  set(program isthmus-${WHAT})
  if(WHAT STREQUAL "client")
    page(1 isthmus)
    set(program isthmus)
  elseif(WHAT STREQUAL "fleet")
    page(8 isthmus-worker)
  endif()
  help_of(help ${BIN}/${program})
  names_below(commands "Subcommands" "${help}")
  foreach(command ${commands})
    page(1 isthmus ${command})
  endforeach()
endif()
