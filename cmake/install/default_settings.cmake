# Writes every setting of SERVER with its default, as comments, to OUTPUT.
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND ${SERVER} --print-config
  OUTPUT_VARIABLE settings COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "\n([^\n])" "\n#\\1" settings "\n${settings}")
file(WRITE "${OUTPUT}" "# Settings of isthmus-server. What is commented out is the default; \
to change a setting,\n# remove the # in front of it and of its section.\n${settings}")
