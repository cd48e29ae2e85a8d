# cmake --install: installs the libraries with their headers and package files (component development), and the program
# with the files that it needs (component program).
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/Typodont)
install(TARGETS typodont_options EXPORT Typodont)
set_target_properties(typodont_options PROPERTIES EXPORT_NAME options)
install(EXPORT Typodont NAMESPACE Typodont:: FILE TypodontTargets.cmake DESTINATION ${package_folder} COMPONENT development)
include(CMakePackageConfigHelpers)
get_property(installed GLOBAL PROPERTY TYPODONT_INSTALLED)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/TypodontConfig.cmake.in ${PROJECT_BINARY_DIR}/TypodontConfig.cmake
                              INSTALL_DESTINATION ${package_folder} PATH_VARS CMAKE_INSTALL_INCLUDEDIR NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/TypodontConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/TypodontConfig.cmake ${PROJECT_BINARY_DIR}/TypodontConfigVersion.cmake
        DESTINATION ${package_folder} COMPONENT development)

# The process that has OpenVDB. The program finds it relative to itself, other programs by
# TYPODONT_OPENVDB.
install(TARGETS typodont_openvdb RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/typodont COMPONENT program)
install(TARGETS typodont_openvdb RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/typodont COMPONENT development)
# The process that reads DICOM files, found in the same way by TYPODONT_DICOM_READER.
if(TARGET typodont_dicom_reader)
  install(TARGETS typodont_dicom_reader RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/typodont COMPONENT program)
  install(TARGETS typodont_dicom_reader RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/typodont COMPONENT development)
endif()
# The part of the calibration that is loaded on use, found in the same way by TYPODONT_CALIBRATION_PART.
if(TARGET typodont_calibration_part)
  foreach(component program library development)
    install(TARGETS typodont_calibration_part LIBRARY DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/typodont
            PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE
            COMPONENT ${component})
  endforeach()
endif()

if(TYPODONT_BUILD_program)
  set(man_page ${PROJECT_BINARY_DIR}/typodont.1)
  add_custom_command(OUTPUT ${man_page}
                     COMMAND ${CMAKE_COMMAND} -D PROGRAM=$<TARGET_FILE:typodont> -D OUT=${man_page}
                             -P ${PROJECT_SOURCE_DIR}/cmake/package/man_page.cmake
                     DEPENDS typodont cmake/package/man_page.cmake VERBATIM)
  add_custom_target(typodont_man_page ALL DEPENDS ${man_page})
  install(TARGETS typodont RUNTIME COMPONENT program)
  install(DIRECTORY assets DESTINATION ${CMAKE_INSTALL_DATADIR}/typodont COMPONENT program)
  install(DIRECTORY engine/school/typodont_school DESTINATION ${CMAKE_INSTALL_DATADIR}/typodont/school COMPONENT program
          PATTERN __pycache__ EXCLUDE)
  install(FILES engine/session/texts/report.json DESTINATION ${CMAKE_INSTALL_DATADIR}/typodont/school/typodont_school
          COMPONENT program)
  install(PROGRAMS cmake/package/typodont-school cmake/package/typodont-hand-in TYPE BIN COMPONENT program)
  install(FILES cmake/package/typodont-school.service cmake/package/typodont-hand-in.service DESTINATION lib/systemd/user
          COMPONENT program)
  install(FILES assets/devices/70-typodont.rules DESTINATION lib/udev/rules.d COMPONENT program)
  install(FILES ${man_page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
  install(FILES cmake/package/typodont.desktop DESTINATION ${CMAKE_INSTALL_DATADIR}/applications COMPONENT program)
  install(FILES cmake/package/typodont.svg DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps COMPONENT program)
  install(FILES LICENSE RENAME copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/typodont COMPONENT program)

  # cpack makes build/package/typodont_VERSION_ARCHITECTURE.deb with the program, libtypodont.so and its headers, and
  # the Python package.
  set(CPACK_GENERATOR DEB)
  set(CPACK_PACKAGE_DIRECTORY ${PROJECT_SOURCE_DIR}/build/package)
  set(CPACK_PACKAGE_CONTACT "Typodont maintainers <maintainers@typodont.invalid>")
  set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
  set(CPACK_COMPONENTS_ALL program)
  set(CPACK_DEB_COMPONENT_INSTALL ON)
  set(CPACK_STRIP_FILES ON)
  set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
  set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "training workbench for hard tissue: see, feel and hear the drill
A co-located visual, haptic and audio workbench for hand-eye training on teeth
and bone. Drives force-feedback arms, mirror workbenches and headsets; without
any hardware it runs on a scripted hand, offscreen, on a processor. With its
haptic core as a library for C and Python.")
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME typodont)
  set(CPACK_DEBIAN_PROGRAM_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
  # The Vulkan loader alone draws nothing. The packages of libraries that are loaded on use are not found automatically.
  get_property(late_packages GLOBAL PROPERTY TYPODONT_LATE_PACKAGES)
  list(REMOVE_DUPLICATES late_packages)
  list(JOIN late_packages ", " late_packages)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "mesa-vulkan-drivers | vulkan-icd, ${late_packages}")
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "ffmpeg, libopenxr-loader1, python3-cffi, python3-numpy")  # films; headsets; Python
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "python3-pandas, python3-distributed, python3-django, python3-waitress, python3-whitenoise, python3-jwt, python3-cryptography, python3-h5py")  # the last six: the school's service
  include(CPack)
endif()
