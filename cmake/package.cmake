# `cpack` makes a Debian package of each component; scripts/package does all of it.
# Debian's way of naming who answers for a package; set it when you publish one.
set(CPACK_PACKAGE_CONTACT "Isthmus maintainers <isthmus@localhost>" CACHE STRING
  "Maintainer of the packages: Name <address>")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME isthmus)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL ${components})
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE
    GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

# isthmus_package(COMPONENT NAME SECTION SUMMARY)
macro(isthmus_package component name section summary)
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_COMPONENT_${upper}_DESCRIPTION ${summary})
  install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} RENAME copyright
    COMPONENT ${component})
endmacro()

isthmus_package(server isthmus-server science
"map server for many LiDAR robots
Takes robots' scans, computes their odometry, finds where their maps overlap and
serves the merged map. Installed, not started: systemctl enable --now isthmus-server")
isthmus_package(client isthmus science
"command line of the Isthmus map server
Pushes scans, asks for the state of the map, downloads and corrects it. The
commands that need no server are in isthmus-offline, isthmus-lab and
isthmus-fleet.")
isthmus_package(offline isthmus-offline science
"commands of isthmus that need no server
Computes odometry of recorded drives, merges maps on disk, rebuilds maps from
archived scans. Brings the libraries that these need.")
isthmus_package(dev libisthmus-client-dev libdevel
"client library of the Isthmus map server, for C++20
Headers and static libraries, for CMake and pkg-config, and examples.")
if(ISTHMUS_FLEET)
  isthmus_package(fleet isthmus-fleet science
"maps of the Isthmus map server in PostgreSQL
Workers that match for the servers of a database, and a command that copies maps
to it and back.")
endif()
if(ISTHMUS_LAB)
  isthmus_package(lab isthmus-lab science
"experiments with the Isthmus map server
Simulates robots, tells the errors of trajectories against the truth, loads a
server; with what was measured.")
endif()

isthmus_package(python python3-isthmus python
"client of the Isthmus map server, for Python 3
Pushes scans and submaps as numpy arrays, reads the merged map and trajectories.
With type hints, and examples, one of them a node for ROS 2.")

# The `report` command draws its figures with Matplotlib.
set(CPACK_DEBIAN_CLIENT_PACKAGE_RECOMMENDS "isthmus-offline, python3-matplotlib")
foreach(component OFFLINE FLEET LAB)
  set(CPACK_DEBIAN_${component}_PACKAGE_DEPENDS "isthmus (= ${PROJECT_VERSION})")
endforeach()
# The packages that had the worker and the load generator before 0.8.0.
foreach(relation BREAKS REPLACES)
  set(CPACK_DEBIAN_FLEET_PACKAGE_${relation} "isthmus-server (<< 0.8.0)")
  set(CPACK_DEBIAN_LAB_PACKAGE_${relation} "isthmus-offline (<< 0.8.0)")
endforeach()
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
  "libabsl-dev, libdraco-dev, libeigen3-dev, libgrpc++-dev, liblzf-dev, libprotobuf-dev, libssl-dev, libzstd-dev, zlib1g-dev, \
protobuf-compiler-grpc")  # CMake asks for the last one when it looks for Debian's gRPC.
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "python3, python3-crc32c, python3-grpcio, python3-numpy, python3-protobuf, python3-zstandard")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS python3-matplotlib)  # For an example.
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
  ${PROJECT_SOURCE_DIR}/cmake/install/files/python/postinst
  ${PROJECT_SOURCE_DIR}/cmake/install/files/python/prerm)
set(CPACK_DEBIAN_SERVER_PACKAGE_CONTROL_EXTRA
  ${PROJECT_SOURCE_DIR}/cmake/install/files/server/conffiles ${PROJECT_SOURCE_DIR}/cmake/install/files/server/postinst
  ${PROJECT_SOURCE_DIR}/cmake/install/files/server/prerm ${PROJECT_SOURCE_DIR}/cmake/install/files/server/postrm)
include(CPack)
