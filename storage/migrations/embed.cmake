# cmake -DFILES="a.sql;b.sql" -DOUTPUT=x.cc -DHEADER=y.h -DFUNCTION=Name -P embed.cmake: the migrations
# as a C++ source that defines the function of the header. The number that a file's name begins with is
# the version of the schema it leads to.

set(text "#include \"${HEADER}\"\n\nnamespace isthmus::storage {\n\n")
string(APPEND text "const std::vector<Migration>& ${FUNCTION}() {\n")
string(APPEND text "  static const std::vector<Migration> kMigrations = {\n")
foreach(file IN LISTS FILES)
  get_filename_component(name "${file}" NAME)
  string(REGEX MATCH "^[0-9]+" number "${name}")
  math(EXPR version "${number}")  # 0001 becomes 1.
  file(READ "${file}" sql)
  string(APPEND text "      {${version}, \"${name}\", R\"sql(${sql})sql\"},\n")
endforeach()
string(APPEND text "  };\n  return kMigrations;\n}\n\n}  // namespace isthmus::storage\n")
file(WRITE "${OUTPUT}" "${text}")
