# The page that shows the map in a browser (client/viewer), built by npm in the build folder, from
# which the server takes it in. Tells server/web where it will be: ISTHMUS_VIEWER_FOLDER, and what to
# wait for: ISTHMUS_VIEWER_STAMP. Without npm neither is set, and the server says so at `/`.

find_program(ISTHMUS_NPM npm)
option(ISTHMUS_VIEWER "Build the page that shows the map in a browser: needs npm, and its registry" ON)
if(ISTHMUS_VIEWER AND NOT ISTHMUS_NPM)
  message(STATUS "No npm: the server will have no page at /. To have one: apt-get install npm")
endif()

if(ISTHMUS_VIEWER AND ISTHMUS_NPM)
  set(viewer_source ${PROJECT_SOURCE_DIR}/client/viewer)
  set(viewer_work ${PROJECT_BINARY_DIR}/viewer/work)
  set(ISTHMUS_VIEWER_FOLDER ${PROJECT_BINARY_DIR}/viewer/dist)
  set(viewer_packages ${PROJECT_BINARY_DIR}/viewer/packages.stamp)
  set(viewer_stamp ${PROJECT_BINARY_DIR}/viewer/viewer.stamp)
  file(GLOB_RECURSE viewer_files CONFIGURE_DEPENDS
    ${viewer_source}/src/* ${viewer_source}/public/*)
  file(GLOB viewer_protos CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/api/isthmus/v1/*.proto)
  set(viewer_settings ${viewer_source}/index.html ${viewer_source}/tsconfig.json
    ${viewer_source}/vite.config.ts)
  set(viewer_plugin ${viewer_source}/protoc-gen-messages)
  set(viewer_locks ${viewer_source}/package.json ${viewer_source}/package-lock.json)

  # Nothing is made in the source folder: npm works on a copy.
  add_custom_command(OUTPUT ${viewer_packages}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${viewer_work}
    COMMAND ${CMAKE_COMMAND} -E copy ${viewer_locks} ${viewer_work}
    COMMAND ${CMAKE_COMMAND} -E chdir ${viewer_work}
      ${ISTHMUS_NPM} ci --ignore-scripts --no-audit --no-fund --loglevel=error
    COMMAND ${CMAKE_COMMAND} -E touch ${viewer_packages}
    DEPENDS ${viewer_locks} COMMENT "Fetching what the viewer is built with (-DISTHMUS_VIEWER=OFF: no viewer, no network)"
    VERBATIM)
  add_custom_command(OUTPUT ${viewer_stamp}
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${viewer_work}/src ${viewer_work}/public
    COMMAND ${CMAKE_COMMAND} -E copy_directory ${viewer_source}/src ${viewer_work}/src
    COMMAND ${CMAKE_COMMAND} -E copy_directory ${viewer_source}/public ${viewer_work}/public
    COMMAND protobuf::protoc -I ${PROJECT_SOURCE_DIR}/api --messages_out=${viewer_work}/src/api
      --plugin=protoc-gen-messages=${viewer_plugin} ${viewer_protos}
    COMMAND ${CMAKE_COMMAND} -E copy ${viewer_settings} ${viewer_work}
    COMMAND ${CMAKE_COMMAND} -E chdir ${viewer_work}
      ${CMAKE_COMMAND} -E env ISTHMUS_VIEWER_OUT=${ISTHMUS_VIEWER_FOLDER}
      ${ISTHMUS_NPM} run --silent build -- --logLevel warn
    COMMAND ${CMAKE_COMMAND} -E touch ${viewer_stamp}
    DEPENDS ${viewer_packages} ${viewer_files} ${viewer_settings} ${viewer_plugin} ${viewer_protos}
    COMMENT "Building the viewer" VERBATIM)
  add_custom_target(isthmus_viewer DEPENDS ${viewer_stamp})
  set(ISTHMUS_VIEWER_STAMP ${viewer_stamp} isthmus_viewer)
endif()
