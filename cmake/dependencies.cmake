# Third-party packages, all from Debian 12. Each is linked by the one folder that needs it.

find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(absl REQUIRED)
find_package(Ceres REQUIRED)
find_package(SQLite3 REQUIRED)
pkg_check_modules(LIBPQ REQUIRED IMPORTED_TARGET libpq)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(embree 3 REQUIRED)
find_package(PNG REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(spdlog REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
pkg_check_modules(FFTW REQUIRED IMPORTED_TARGET fftw3f)
pkg_check_modules(PCAP REQUIRED IMPORTED_TARGET libpcap)
pkg_check_modules(GEOGRAPHICLIB REQUIRED IMPORTED_TARGET geographiclib)
find_package(liblzf REQUIRED)
find_package(zstd REQUIRED)
find_package(BZip2 REQUIRED)
pkg_check_modules(LZ4 REQUIRED IMPORTED_TARGET liblz4)

# VTK would bring in Qt and 35 targets of its own; the PCL modules used here do without it.
if(ISTHMUS_PAPER)
  set(CMAKE_DISABLE_FIND_PACKAGE_VTK ON)
  find_package(PCL 1.13 REQUIRED QUIET COMPONENTS common kdtree search filters features keypoints)
endif()

# Debian's Protobuf has no CMake config of its own: the module finds it.
find_package(Protobuf REQUIRED)
if(ISTHMUS_WITH_GRPC)
  find_package(gRPC CONFIG REQUIRED)
  # By pkg-config: the CMake files of prometheus-cpp would bring in CURL.
  pkg_check_modules(PROMETHEUS REQUIRED IMPORTED_TARGET prometheus-cpp-core)
  pkg_check_modules(MICROHTTPD REQUIRED IMPORTED_TARGET libmicrohttpd)
  pkg_check_modules(GNUTLS REQUIRED IMPORTED_TARGET gnutls)  # That libmicrohttpd does TLS by.
endif()
if(ISTHMUS_TESTS)
  find_package(GTest REQUIRED)
endif()
# It judges the files that we write in its formats.
if(ISTHMUS_TESTS OR ISTHMUS_BENCHMARKS)
  find_package(octomap REQUIRED)
endif()
if(ISTHMUS_BENCHMARKS)
  find_package(benchmark REQUIRED)
endif()
# By pkg-config: ROS's CMake files would bring in catkin. Its messages are headers only.
if(ISTHMUS_ROS1)
  pkg_check_modules(ROS REQUIRED IMPORTED_TARGET roscpp tf2_ros)
  include(cmake/ros1_messages.cmake)
endif()
