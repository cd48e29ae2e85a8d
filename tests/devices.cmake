# Tests of devices against emulations that speak the protocol; none needs hardware.
add_library(typodont_device_emulation STATIC support/emulation/emulated_arm.cpp support/emulation/haply_service.cpp
            support/emulation/live_board.cpp)
target_link_libraries(typodont_device_emulation PUBLIC typodont_devices PRIVATE nlohmann_json::nlohmann_json util)
typodont_test(stress_devices KIND stress SOURCES stress/device_faults_test.cpp stress/device_attacks_test.cpp LIBS typodont_devices typodont_device_emulation)
typodont_test(unit_devices KIND unit
  SOURCES unit/device_arm_test.cpp unit/device_protocols_test.cpp unit/device_safety_test.cpp
          unit/device_links_test.cpp unit/device_vendors_test.cpp unit/device_registry_test.cpp unit/device_timing_test.cpp unit/device_hotplug_test.cpp
  LIBS typodont_devices typodont_device_emulation)
typodont_test(property_devices KIND property SOURCES property/device_parsers_test.cpp LIBS typodont_devices typodont_device_emulation)
# Tests of the whole program with an emulated arm. They run one at a time, because they depend on real time.
typodont_test(stress_hands KIND stress SOURCES stress/hands_live_test.cpp LIBS typodont_app typodont_device_emulation LIVE)
add_library(standin_clock SHARED support/emulation/standin_clock.cpp)
target_link_libraries(standin_clock PRIVATE typodont_options ${CMAKE_DL_LIBS})
target_compile_definitions(stress_hands PRIVATE TYPODONT_PROGRAM="$<TARGET_FILE:typodont>"
                                                TYPODONT_STANDIN_CLOCK="$<TARGET_FILE:standin_clock>")
add_dependencies(stress_hands typodont standin_clock)
# Tests in which a thousand processes are killed each. They run alone, because they depend on real time.
typodont_test(stress_ends KIND stress SOURCES stress/device_ends_test.cpp LIBS typodont_devices typodont_device_emulation
              LIVE ALONE)
# Replacements for vendors' libraries with the same names and interfaces. A test loads them under the vendor's soname
# before a driver requests it.
foreach(vendor hd dhd)
  add_library(standin_${vendor} SHARED support/emulation/standin_${vendor}.cpp)
  target_link_libraries(standin_${vendor} PRIVATE typodont_options)
  add_dependencies(unit_devices standin_${vendor})
endforeach()
set_target_properties(standin_hd PROPERTIES LIBRARY_OUTPUT_NAME HD)
set_target_properties(standin_dhd PROPERTIES LIBRARY_OUTPUT_NAME dhd SOVERSION 3)
target_compile_definitions(unit_devices PRIVATE TYPODONT_STANDIN_HD="$<TARGET_FILE:standin_hd>"
                                                TYPODONT_STANDIN_DHD="$<TARGET_FILE:standin_dhd>")
target_link_libraries(unit_devices PRIVATE util ${CMAKE_DL_LIBS})
typodont_test(acceptance_devices KIND acceptance SOURCES acceptance/devices_command_test.cpp LIBS typodont_base util)
target_compile_definitions(acceptance_devices PRIVATE TYPODONT_PROGRAM="$<TARGET_FILE:typodont>"
                           TYPODONT_STANDIN_HD="$<TARGET_FILE:standin_hd>" TYPODONT_STANDIN_DHD="$<TARGET_FILE:standin_dhd>")
add_dependencies(acceptance_devices typodont standin_hd standin_dhd)

# hidraw nodes by umockdev: its wrapper preloads a library that simulates /dev, /sys and udev. Not with sanitizers,
# which must be preloaded first themselves.
pkg_check_modules(UMOCKDEV IMPORTED_TARGET umockdev-1.0)
find_program(UMOCKDEV_WRAPPER umockdev-wrapper)
if(TYPODONT_HIDAPI AND UMOCKDEV_FOUND AND UMOCKDEV_WRAPPER AND NOT TYPODONT_SANITIZE)
  typodont_test(stress_umockdev KIND stress SOURCES stress/device_umockdev_test.cpp
                LIBS typodont_devices typodont_session PkgConfig::UMOCKDEV fmt::fmt LIVE LAUNCHER ${UMOCKDEV_WRAPPER})
  target_compile_definitions(stress_umockdev PRIVATE TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
  add_dependencies(stress_umockdev typodont)
endif()
