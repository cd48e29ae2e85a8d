# Finds packages, each only if a part that is built needs it; comments say where the order matters. Packages for scans
# and meshes, and OpenCV, are searched where they are used.
find_package(Threads REQUIRED)            # before glslang
find_package(glm CONFIG REQUIRED)
find_package(fmt CONFIG REQUIRED)
find_package(nlohmann_json CONFIG REQUIRED)
find_package(OpenSSL 3 REQUIRED COMPONENTS Crypto)
find_package(ZLIB REQUIRED)
if(TYPODONT_BUILD_haptics)
  find_package(TBB CONFIG REQUIRED)       # before OpenVDB and Ceres, which disagree on how to find it
  list(APPEND CMAKE_MODULE_PATH /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB)
  find_package(OpenVDB MODULE REQUIRED)
  # Levels of detail of meshes (model mesh_lod). Required by the program, optional for the library alone.
  if(TYPODONT_BUILD_program)
    find_package(meshoptimizer CONFIG REQUIRED)
  else()
    find_package(meshoptimizer CONFIG QUIET)
  endif()
endif()
if(TYPODONT_BUILD_audio OR TYPODONT_BUILD_calibration)
  find_package(Eigen3 CONFIG REQUIRED)
  if(TYPODONT_SANITIZE)  # else, under AddressSanitizer, Eigen aligns memory in another way than the Ceres that frees it
    target_compile_definitions(Eigen3::Eigen INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
  endif()
endif()
if(TYPODONT_BUILD_calibration)
  find_package(Ceres CONFIG REQUIRED)
endif()
if(TYPODONT_BUILD_import OR TYPODONT_BUILD_program)
  find_package(PNG REQUIRED)
endif()
if(TYPODONT_BUILD_audio)
  find_package(PkgConfig REQUIRED)
  pkg_check_modules(SNDFILE REQUIRED IMPORTED_TARGET sndfile)
  pkg_check_modules(FFTW3 REQUIRED IMPORTED_TARGET fftw3)
  if(TYPODONT_PORTAUDIO)
    pkg_check_modules(PORTAUDIO REQUIRED IMPORTED_TARGET portaudio-2.0)
  endif()
endif()
if(TYPODONT_BUILD_devices AND TYPODONT_HIDAPI)
  find_package(PkgConfig REQUIRED)
  pkg_check_modules(HIDAPI REQUIRED IMPORTED_TARGET hidapi-hidraw)
endif()
if(TYPODONT_BUILD_program)
  find_package(CLI11 CONFIG REQUIRED)
  find_package(Vulkan REQUIRED)
  # Programs are linked with HDF5's archives, because its shared library loads 28 others: for example curl and Kerberos,
  # for files in a network. Functions that need these are not linked. libtypodont.so is linked with the shared library,
  # because Debian's archives are not position-independent.
  find_package(HDF5 REQUIRED COMPONENTS C)
  add_library(typodont_hdf5 INTERFACE)
  target_include_directories(typodont_hdf5 SYSTEM INTERFACE ${HDF5_C_INCLUDE_DIRS})
  set(in_shared_library $<STREQUAL:$<TARGET_PROPERTY:TYPE>,SHARED_LIBRARY>)
  target_link_libraries(typodont_hdf5 INTERFACE $<${in_shared_library}:hdf5::hdf5>)
  foreach(archive hdf5 sz aec)
    find_library(HDF5_${archive}_ARCHIVE lib${archive}.a PATH_SUFFIXES hdf5/serial REQUIRED)
    target_link_libraries(typodont_hdf5 INTERFACE $<$<NOT:${in_shared_library}>:${HDF5_${archive}_ARCHIVE}>)
  endforeach()
  target_link_libraries(typodont_hdf5 INTERFACE ZLIB::ZLIB ${CMAKE_DL_LIBS})
  find_package(PkgConfig REQUIRED)
  pkg_check_modules(CAIRO REQUIRED IMPORTED_TARGET cairo cairo-pdf cairo-svg)
  pkg_check_modules(LIBLO IMPORTED_TARGET liblo)  # optional: OSC
  find_program(GLSLANG_VALIDATOR glslangValidator REQUIRED)
  if(TYPODONT_WINDOW)
    find_package(glfw3 CONFIG REQUIRED)
    pkg_check_modules(IMGUI REQUIRED IMPORTED_TARGET imgui)
    pkg_check_modules(XEXT REQUIRED IMPORTED_TARGET x11 xext xcb)
  endif()
  if(TYPODONT_OPENXR)
    find_package(OpenXR CONFIG REQUIRED)  # its headers: the loader is opened at run time, in a headset only
  endif()
endif()
if(TYPODONT_TESTS)
  find_package(GTest CONFIG REQUIRED)
endif()

# typodont_late(NAME LIBRARY PACKAGE file.cpp …): these files use LIBRARY without being linked with it
# (engine/base/late_library.h). Defines TYPODONT_LATE_NAME for them: the file to load and Debian's package with it.
function(typodont_late name library package)
  find_library(${name}_FILE ${library} REQUIRED)
  execute_process(COMMAND ${CMAKE_OBJDUMP} -p ${${name}_FILE} OUTPUT_VARIABLE headers COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCH "SONAME +([^\n]+)" unused "${headers}")
  set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_DEFINITIONS
               "TYPODONT_LATE_${name}=\"${CMAKE_MATCH_1}\",\"${package}\"")
  set_property(GLOBAL APPEND PROPERTY TYPODONT_LATE_PACKAGES ${package})
endfunction()

# typodont_headers_of(TARGET library …): TARGET includes the headers of these libraries, and is not linked with them.
function(typodont_headers_of target)
  foreach(library ${ARGN})
    target_include_directories(${target} SYSTEM PRIVATE
      $<BUILD_INTERFACE:$<TARGET_PROPERTY:${library},INTERFACE_INCLUDE_DIRECTORIES>>)
  endforeach()
endfunction()
