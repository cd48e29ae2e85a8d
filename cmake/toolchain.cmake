# Language, warnings, sanitizers, folders of an installation, and the tools that make a build fast where they are present.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

include(GNUInstallDirs)

find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
endif()
find_program(MOLD mold)
if(MOLD)
  add_link_options(-fuse-ld=mold)
endif()

# What every user of a library needs, and no more.
add_library(typodont_options INTERFACE)
target_compile_features(typodont_options INTERFACE cxx_std_20)
target_include_directories(typodont_options INTERFACE
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/typodont>)
# Vulkan clip space: depth 0..1. Set once for all, so that no file can disagree.
target_compile_definitions(typodont_options INTERFACE GLM_FORCE_DEPTH_ZERO_TO_ONE GLM_ENABLE_EXPERIMENTAL)

# What this tree is compiled with: properties of the directory, so none of them reaches the users of a library.
add_compile_options(
  "$<$<COMPILE_LANGUAGE:CXX>:-Wall;-Wextra;-Wpedantic;$<$<CXX_COMPILER_ID:GNU>:-Werror>;-Wshadow;-Wconversion;-Wno-sign-conversion;-Wnon-virtual-dtor;-Woverloaded-virtual>"
  -ffp-contract=off)  # the same bits with and without FMA: replays are compared bit for bit
add_compile_definitions(TYPODONT_VERSION="${PROJECT_VERSION}")

if(TYPODONT_SANITIZE)
  add_compile_options(-fsanitize=${TYPODONT_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${TYPODONT_SANITIZE})
  # GCC 12 warns about the standard library's own <regex> and fences here, and only here.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    add_compile_options(-Wno-error=maybe-uninitialized)
    # Lines for the reports, no variables, and little optimised: GCC 12 compiles instrumented code several times as fast.
    add_compile_options(-O1 -g1)
    if(TYPODONT_SANITIZE MATCHES "thread")
      add_compile_options(-Wno-error=tsan)
    endif()
  else()
    # oneTBB's end iterators are not aligned as Clang would have them; functions of vendors' libraries, found at run time,
    # are declared by us and so of types of ours.
    add_compile_options(-fno-sanitize=alignment,function)
  endif()
endif()
