# Programs of others beside ours (tests/peers/README.md), where they are installed.
function(typodont_add_peer name)
  add_executable(peers_${name} peers/${name}.cpp peers/peer.cpp)
  target_link_libraries(peers_${name} PRIVATE typodont_test_tissues)
  set_target_properties(peers_${name} PROPERTIES EXCLUDE_FROM_ALL ON)
endfunction()

find_package(chai3d CONFIG QUIET)
if(chai3d_FOUND)
  typodont_add_peer(chai3d)
  target_compile_definitions(peers_chai3d PRIVATE LINUX)  # its headers ask for it
  target_include_directories(peers_chai3d SYSTEM PRIVATE ${CHAI3D_INCLUDE_DIRS})
  target_link_directories(peers_chai3d PRIVATE ${CHAI3D_LIBRARY_DIRS})
  target_link_libraries(peers_chai3d PRIVATE ${CHAI3D_LIBRARIES})
else()
  add_custom_target(peers_chai3d VERBATIM COMMAND ${CMAKE_COMMAND} -E echo
                    "no CHAI3D is found here: it adds no rows. Set chai3d_DIR to the folder of chai3dConfig.cmake.")
endif()
