// The udev rules that let the user at the console open the devices (assets/devices/70-typodont.rules), inside the
// program.
#pragma once

#include <filesystem>
#include <string_view>

namespace typodont::haptics {

std::string_view udev_rules();

/// Writes them into `folder`, whole or not at all. Returns the file. Throws Error that names the command to run instead
/// where it may not.
std::filesystem::path install_udev_rules(const std::filesystem::path& folder);

}  // namespace typodont::haptics
