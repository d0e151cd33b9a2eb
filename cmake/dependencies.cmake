# Third-party packages, all from Debian 12. Each is linked by the one folder that needs it.

find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(absl REQUIRED)
find_package(Ceres REQUIRED)
find_package(SQLite3 REQUIRED)
find_package(octomap REQUIRED)
find_package(embree 3 REQUIRED)
find_package(PNG REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(spdlog REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(FFTW REQUIRED IMPORTED_TARGET fftw3f)
find_package(liblzf REQUIRED)

# VTK would bring in Qt and 35 targets of its own; the PCL modules used here do without it.
set(CMAKE_DISABLE_FIND_PACKAGE_VTK ON)
find_package(PCL 1.13 REQUIRED QUIET COMPONENTS common kdtree search filters features keypoints)

if(ISTHMUS_WITH_GRPC)
  # Debian's Protobuf has no CMake config of its own: the module finds it.
  find_package(Protobuf REQUIRED)
  find_package(gRPC CONFIG REQUIRED)
endif()
if(ISTHMUS_TESTS)
  find_package(GTest REQUIRED)
endif()
if(ISTHMUS_BENCHMARKS)
  find_package(benchmark REQUIRED)
endif()
