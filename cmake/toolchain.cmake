# Language, warnings, sanitizers, installation folders, and tools that make a build fast if they are present.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

include(GNUInstallDirs)

find_program(CCACHE ccache)
if(CCACHE)
  # The base directory makes paths relative, so that another checkout of the same files finds the same objects.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros
    CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${CCACHE})
endif()
find_program(MOLD mold)
if(MOLD)
  add_link_options(-fuse-ld=mold)
endif()

# Settings that every user of a library needs, and no others.
add_library(typodont_options INTERFACE)
target_compile_features(typodont_options INTERFACE cxx_std_20)
target_include_directories(typodont_options INTERFACE
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/typodont>)
# Vulkan clip space with depth 0..1, set once so that all files agree.
target_compile_definitions(typodont_options INTERFACE GLM_FORCE_DEPTH_ZERO_TO_ONE GLM_ENABLE_EXPERIMENTAL)

# Settings for compiling this tree. They are properties of the directory, so that users of a library do not inherit
# them.
add_compile_options(
  "$<$<COMPILE_LANGUAGE:CXX>:-Wall;-Wextra;-Wpedantic;$<$<CXX_COMPILER_ID:GNU>:-Werror>;-Wshadow;-Wconversion;-Wno-sign-conversion;-Wnon-virtual-dtor;-Woverloaded-virtual>"
  -ffp-contract=off  # the same bits with and without FMA: replays are compared bit for bit
  # Square roots need not set errno and comparisons need not trap, so that loops can be vectorised. NaN stays allowed.
  -fno-math-errno -fno-trapping-math
  -fno-semantic-interposition)  # inlines functions that a shared library could otherwise replace
set(CMAKE_UNITY_BUILD_BATCH_SIZE 18)  # files of a module that are compiled at once
if(TYPODONT_UNITY)  # there, a class may have members with types of its own file
  add_compile_options("$<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>")
endif()
add_compile_definitions(TYPODONT_VERSION="${PROJECT_VERSION}")

if(TYPODONT_SANITIZE)
  add_compile_options(-fsanitize=${TYPODONT_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${TYPODONT_SANITIZE})
  # GCC 12 gives wrong warnings about the standard library's <regex> and about fences, only here.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    add_compile_options(-Wno-error=maybe-uninitialized)
    # Line numbers for the reports, no variables, and little optimisation, because GCC 12 then compiles instrumented
    # code several times faster.
    add_compile_options(-O1 -g1)
    if(TYPODONT_SANITIZE MATCHES "thread")
      add_compile_options(-Wno-error=tsan)
    endif()
  else()
    # oneTBB's end iterators do not have the alignment that Clang expects; and functions of vendors' libraries, found at
    # run time, are declared by us and so have types of ours.
    add_compile_options(-fno-sanitize=alignment,function)
  endif()
endif()
