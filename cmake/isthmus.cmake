# Our own targets: warnings as errors, one include root, the sanitizers of the preset.

add_library(isthmus_flags INTERFACE)
target_include_directories(isthmus_flags INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(isthmus_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Werror)
if(NOT ISTHMUS_PAPER)
  target_compile_definitions(isthmus_flags INTERFACE ISTHMUS_WITHOUT_PAPER)
endif()
if(ISTHMUS_SANITIZE)
  target_compile_options(isthmus_flags INTERFACE
    -O1 -fsanitize=${ISTHMUS_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  if(ISTHMUS_SANITIZE MATCHES address)
    # The checks of every pointer that is followed take as long to compile as all else; what they
    # find AddressSanitizer and the processor mostly find too.
    # GCC 12 takes std::regex for uninitialized then.
    target_compile_options(isthmus_flags INTERFACE -fno-sanitize=null,alignment,object-size,vptr
      -Wno-maybe-uninitialized)
  endif()
  target_link_options(isthmus_flags INTERFACE -fsanitize=${ISTHMUS_SANITIZE})
  # Eigen brings its own aligned malloc where it sees AddressSanitizer; PCL's libraries, built
  # without, use the system's, and what one of them allocates the other frees.
  target_compile_definitions(isthmus_flags INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()
if(ISTHMUS_FUZZERS)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES Clang)
    message(FATAL_ERROR "ISTHMUS_FUZZERS needs clang: configure with CXX=clang++ CC=clang")
  endif()
  # Our code reports its coverage to the fuzzer.
  target_compile_options(isthmus_flags INTERFACE -fsanitize=fuzzer-no-link,address -g1)
  target_link_options(isthmus_flags INTERFACE -fsanitize=address)
endif()

# Also of what the build makes.
set(ISTHMUS_PYTHON /usr/bin/python3 CACHE FILEPATH "Debian's Python, which has gRPC")

# Hot numeric code is compiled with -O3 (HOT below), the rest with -O2: a tenth less to compile.
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")

# With ISTHMUS_UNITY a target's sources are compiled two dozen at a time, which takes less than half
# the time from nothing. Names in unnamed namespaces must then differ from file to file.
function(isthmus_unity target)
  if(ISTHMUS_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 24)
    # A class that a source file declares in its header and defines by its own local types: gcc
    # warns of them, clang does not know the warning.
    target_compile_options(${target} PRIVATE
                           $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
endfunction()

# isthmus_library(NAME [HOT] [SEPARATE] SOURCES ... [DEPS public...] [PRIVATE third-party...])
# SEPARATE: every source for itself also with ISTHMUS_UNITY.
function(isthmus_library name)
  cmake_parse_arguments(ARG "HOT;SEPARATE" "" "SOURCES;DEPS;PRIVATE" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  if(NOT ARG_SEPARATE)
    isthmus_unity(${name})
  endif()
  if(ARG_HOT)
    target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O3>)
  endif()
  # The flags are for us, not for who uses an installed library.
  target_link_libraries(${name} PUBLIC $<BUILD_INTERFACE:isthmus_flags> ${ARG_DEPS} PRIVATE ${ARG_PRIVATE})
endfunction()

# isthmus_test(NAME [SEPARATE] [WHOLE] [COST seconds] [PREFIX before the names of its tests] SOURCES ...
# DEPS ...): a GoogleTest program; each test is one CTest test, or with WHOLE, for those that share
# what is dear to start, all of them are. The costly ones are started first.
function(isthmus_test name)
  cmake_parse_arguments(ARG "SEPARATE;WHOLE" "COST;PREFIX" "SOURCES;DEPS" ${ARGN})
  set(timeout 600)  # Ends a test that hangs; the dearest takes half a minute by itself.
  if(ISTHMUS_SANITIZE)
    set(timeout 1200)  # The sanitizers' checks take less than ten times as long.
  endif()
  if(NOT ARG_COST)
    set(ARG_COST 1)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  if(NOT ARG_SEPARATE)
    isthmus_unity(${name})
  endif()
  # A fifth less to compile than with -O2; what takes time in them is in the libraries.
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  target_link_libraries(${name} PRIVATE ${ARG_DEPS} GTest::gmock GTest::gtest_main)
  if(ARG_WHOLE)
    math(EXPR timeout "5 * ${timeout}")
    add_test(NAME ${ARG_PREFIX}${name} COMMAND ${name})
    set_tests_properties(${ARG_PREFIX}${name} PROPERTIES TIMEOUT ${timeout} COST ${ARG_COST})
    return()
  endif()
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST TEST_PREFIX "${ARG_PREFIX}"
                       PROPERTIES TIMEOUT ${timeout} COST ${ARG_COST})
endfunction()
