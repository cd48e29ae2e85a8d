// The udev rules that let the user at the console open the devices: the content of assets/devices/70-typodont.rules,
// compiled in.
#pragma once

#include <filesystem>
#include <string_view>

namespace typodont::haptics {

std::string_view udev_rules();

/// Writes the rules into `folder`, completely or not at all. Returns the file. Without permission, throws Error with
/// the command to run instead.
std::filesystem::path install_udev_rules(const std::filesystem::path& folder);

}  // namespace typodont::haptics
