// The udev rules that give the user at the console access to the devices. They are the content of
// assets/devices/70-typodont.rules, compiled into the program.
#pragma once

#include <filesystem>
#include <string_view>

namespace typodont::haptics {

std::string_view udev_rules();

/// Writes the rules into `folder`, completely or not at all. Returns the path of the file. Without write permission,
/// throws an Error that contains the command to run instead.
std::filesystem::path install_udev_rules(const std::filesystem::path& folder);

}  // namespace typodont::haptics
