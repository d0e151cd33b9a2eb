# Rules of `cmake --install`, in components: server, client, offline, dev and python, and fleet and
# lab if they are built. `cpack` makes a Debian package of each; see package.cmake.

set(install_dir ${CMAKE_CURRENT_LIST_DIR}/install)

# One page of docs for a package that comes without the others.
function(install_page page package component)
  install(CODE "
    set(SOURCE \"${PROJECT_SOURCE_DIR}/docs\")
    set(PAGES ${page})
    set(OUTPUT \"${CMAKE_BINARY_DIR}/installed_page/${package}\")
    include(\"${install_dir}/docs.cmake\")
    unset(PAGES)" COMPONENT ${component})
  install(FILES ${CMAKE_BINARY_DIR}/installed_page/${package}/${page}
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component})
endfunction()

# The programs.
install(TARGETS isthmus RUNTIME COMPONENT client)
install(TARGETS isthmus-offline
  RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/isthmus COMPONENT offline)
install(TARGETS isthmus-server RUNTIME COMPONENT server)
set(components server client offline dev python)
if(ISTHMUS_FLEET)
  list(APPEND components fleet)
  install(TARGETS isthmus-fleet
    RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/isthmus COMPONENT fleet)
  install(TARGETS isthmus-worker RUNTIME COMPONENT fleet)
endif()
if(ISTHMUS_LAB)
  list(APPEND components lab)
  install(TARGETS isthmus-lab
    RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/isthmus COMPONENT lab)
  install(TARGETS isthmus-loadgen RUNTIME COMPONENT lab)
endif()

# Their manual pages, made of their --help.
find_program(HELP2MAN help2man)
if(HELP2MAN)
  set(with_programs ${components})
  list(REMOVE_ITEM with_programs dev python)
  foreach(component ${with_programs})
    set(pages ${CMAKE_BINARY_DIR}/man/${component})
    install(CODE "
      set(HELP2MAN \"${HELP2MAN}\")
      set(VERSION \"${PROJECT_VERSION}\")
      set(BIN \"${CMAKE_RUNTIME_OUTPUT_DIRECTORY}\")
      set(WHAT ${component})
      set(INCLUDE \"${PROJECT_SOURCE_DIR}/cmake/install/files/isthmus.h2m\")
      set(OUTPUT \"${pages}\")
      include(\"${install_dir}/man_pages.cmake\")" COMPONENT ${component})
    install(DIRECTORY ${pages}/ DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT ${component})
  endforeach()
else()
  message(STATUS "help2man is missing: no manual pages are installed")
endif()

# Completion for bash, which loads it by the name of the program.
set(completions ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES cmake/install/files/isthmus.bash
  DESTINATION ${completions} RENAME isthmus COMPONENT client)
install(FILES cmake/install/files/isthmus.bash
  DESTINATION ${completions} RENAME isthmus-server COMPONENT server)
if(ISTHMUS_FLEET)
  install(FILES cmake/install/files/isthmus.bash
    DESTINATION ${completions} RENAME isthmus-worker COMPONENT fleet)
endif()

# The server as a service, and its settings, all of them commented out: the defaults hold. What is
# configured for /usr has its settings in /etc.
set(settings_full_dir ${CMAKE_INSTALL_FULL_SYSCONFDIR}/isthmus)
set(settings_dir ${CMAKE_INSTALL_SYSCONFDIR}/isthmus)
if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  set(settings_dir ${settings_full_dir})
endif()
# The unit names the program and the settings where this very installation puts them: --prefix may
# be another one than was configured.
configure_file(cmake/install/files/isthmus-server.service.in isthmus-server.service @ONLY)
install(CODE "
  set(CMAKE_INSTALL_FULL_BINDIR \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}\")
  set(settings_full_dir \"${settings_dir}\")
  cmake_path(ABSOLUTE_PATH settings_full_dir BASE_DIRECTORY \"\${CMAKE_INSTALL_PREFIX}\")
  configure_file(\"${PROJECT_SOURCE_DIR}/cmake/install/files/isthmus-server.service.in\"
    \"${CMAKE_BINARY_DIR}/isthmus-server.service\" @ONLY)" COMPONENT server)
install(FILES ${CMAKE_BINARY_DIR}/isthmus-server.service
  DESTINATION lib/systemd/system COMPONENT server)
# For who watches it; see docs/metrics.md.
install(DIRECTORY cmake/install/files/metrics/
  DESTINATION ${CMAKE_INSTALL_DATADIR}/isthmus/metrics COMPONENT server)
install_page(metrics.md isthmus-server server)
install(CODE "
  set(SERVER \"$<TARGET_FILE:isthmus-server>\")
  set(OUTPUT \"${CMAKE_BINARY_DIR}/server.yaml\")
  include(\"${install_dir}/default_settings.cmake\")" COMPONENT server)
install(FILES ${CMAKE_BINARY_DIR}/server.yaml
  DESTINATION ${settings_dir} COMPONENT server)

# The client library. Headers are rewritten to include each other as <isthmus/...>.
set(public_headers
  client/library/client.h core/codec/payload_builder.h core/formats/kitti_bin.h
  core/formats/map_writer.h core/formats/pcd.h core/formats/tum.h)
install(CODE "
  set(SOURCE \"${PROJECT_SOURCE_DIR}\")
  set(HEADERS \"${public_headers}\")
  set(OUTPUT \"${CMAKE_BINARY_DIR}/public_headers\")
  include(\"${install_dir}/public_headers.cmake\")" COMPONENT dev)
install(DIRECTORY ${CMAKE_BINARY_DIR}/public_headers/isthmus
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev)

# Sets client_libraries: ours that the target needs, each before those it needs itself.
function(collect_libraries target)
  get_target_property(needed ${target} INTERFACE_LINK_LIBRARIES)
  foreach(library ${needed})
    string(REGEX REPLACE "^\\$<LINK_ONLY:(.*)>$" "\\1" library "${library}")
    if(library MATCHES "^isthmus_" AND NOT library IN_LIST client_libraries)
      collect_libraries(${library})
    endif()
  endforeach()
  list(PREPEND client_libraries ${target})
  set(client_libraries ${client_libraries} PARENT_SCOPE)
endfunction()

set(client_libraries)
collect_libraries(isthmus_client)
foreach(library ${client_libraries})  # Only isthmus::client is promised.
  string(REPLACE isthmus_ "" short_name ${library})
  set_target_properties(${library} PROPERTIES EXPORT_NAME ${short_name})
endforeach()
install(TARGETS ${client_libraries} EXPORT isthmus-targets
  ARCHIVE COMPONENT dev INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})

include(CMakePackageConfigHelpers)
set(config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/isthmus)
install(EXPORT isthmus-targets NAMESPACE isthmus:: DESTINATION ${config_dir} COMPONENT dev)
configure_package_config_file(cmake/install/files/isthmus-config.cmake.in
  ${CMAKE_BINARY_DIR}/isthmus-config.cmake INSTALL_DESTINATION ${config_dir})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/isthmus-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/isthmus-config.cmake
  ${CMAKE_BINARY_DIR}/isthmus-config-version.cmake DESTINATION ${config_dir} COMPONENT dev)

cmake_path(RELATIVE_PATH CMAKE_INSTALL_PREFIX
  BASE_DIRECTORY ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig OUTPUT_VARIABLE prefix_from_pkgconfig)
list(TRANSFORM client_libraries PREPEND -l OUTPUT_VARIABLE client_link_options)
list(JOIN client_link_options " " client_link_options)
configure_file(cmake/install/files/isthmus-client.pc.in isthmus-client.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/isthmus-client.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)

# install_pages(FOLDER PACKAGE COMPONENT): all pages of a folder, as they link to each other.
function(install_pages folder package component)
  set(pages ${CMAKE_BINARY_DIR}/installed_docs/${package})
  install(CODE "
    set(SOURCE \"${PROJECT_SOURCE_DIR}/${folder}\")
    set(OUTPUT \"${pages}\")
    include(\"${install_dir}/docs.cmake\")" COMPONENT ${component})
  install(DIRECTORY ${pages}/
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component})
endfunction()
install_pages(docs isthmus client)
if(ISTHMUS_LAB)
  install_pages(lab/docs isthmus-lab lab)
endif()
install(DIRECTORY client/examples/ DESTINATION ${CMAKE_INSTALL_DATADIR}/isthmus/examples
  COMPONENT dev FILES_MATCHING PATTERN "*.cc")
# To build them as a user of the library does.
install(FILES cmake/install/files/examples/CMakeLists.txt
  DESTINATION ${CMAKE_INSTALL_DATADIR}/isthmus/examples COMPONENT dev)

# The Python package, where Debian's Python looks for it: below /usr in a folder for all versions of
# Python 3, elsewhere in one for its own.
if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  set(python_packages lib/python3/dist-packages)
else()
  execute_process(COMMAND ${ISTHMUS_PYTHON} -c "import sys; print('%d.%d' % sys.version_info[:2])"
    OUTPUT_VARIABLE python_version OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  set(python_packages lib/python${python_version}/dist-packages)
endif()
install(DIRECTORY client/python/isthmus DESTINATION ${python_packages} COMPONENT python
  FILES_MATCHING PATTERN "*.py" PATTERN "py.typed" PATTERN "__pycache__" EXCLUDE)
install(DIRECTORY ${PROJECT_BINARY_DIR}/python/isthmus/v1 DESTINATION ${python_packages}/isthmus
  COMPONENT python FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN "__pycache__" EXCLUDE)
install_page(python.md python3-isthmus python)
install(DIRECTORY client/python/examples
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-isthmus COMPONENT python
  FILES_MATCHING PATTERN "*.py" PATTERN "*.md" PATTERN "__pycache__" EXCLUDE)
