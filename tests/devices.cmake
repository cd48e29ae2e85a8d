# Devices: everything is tried against emulations that speak the protocol; none of it needs hardware.
add_library(typodont_device_emulation STATIC support/emulation/emulated_arm.cpp support/emulation/haply_service.cpp)
target_link_libraries(typodont_device_emulation PUBLIC typodont_devices PRIVATE nlohmann_json::nlohmann_json)
typodont_test(stress_devices KIND stress SOURCES stress/device_faults_test.cpp LIBS typodont_devices typodont_device_emulation)
