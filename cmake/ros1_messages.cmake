# Debian's ROS messages name std::allocator<void>::rebind, which C++20 has no more. Copies of the
# headers that do, with the allocator_traits that C++11 put in its place: the types are the same.
# The target isthmus_ros1_messages has them found before the system's.
set(fixed_dir ${PROJECT_BINARY_DIR}/ros1/include)
pkg_get_variable(ROS_PREFIX roscpp prefix)
set(ros_include ${ROS_PREFIX}/include)
file(GLOB ros_headers RELATIVE ${ros_include} ${ros_include}/*_msgs/*.h ${ros_include}/ros/*.h
  ${ros_include}/roscpp/*.h)
foreach(header ${ros_headers})
  file(READ ${ros_include}/${header} text)
  if(text MATCHES "ContainerAllocator::template rebind<")
    string(REPLACE "ContainerAllocator::template rebind<"
      "std::allocator_traits<ContainerAllocator>::template rebind_traits<" text "${text}")
    string(REPLACE "::other" "::allocator_type" text "${text}")
    string(REGEX REPLACE "#include \"([a-z_]+\\.h)\"" "#include <ros/\\1>" text "${text}")
    file(CONFIGURE OUTPUT ${fixed_dir}/${header} CONTENT "${text}" @ONLY)
  endif()
endforeach()
add_library(isthmus_ros1_messages INTERFACE)
target_include_directories(isthmus_ros1_messages SYSTEM BEFORE INTERFACE ${fixed_dir})
