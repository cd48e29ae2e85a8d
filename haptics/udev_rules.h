// Access for the user at the console: assets/devices/70-typodont.rules, compiled in.
#pragma once

#include <filesystem>
#include <string_view>

namespace typodont::haptics {

std::string_view udev_rules();

/// Into `folder`, completely or not at all; returns the path. Throws Error with the command to run, without permission.
std::filesystem::path install_udev_rules(const std::filesystem::path& folder);

}  // namespace typodont::haptics
