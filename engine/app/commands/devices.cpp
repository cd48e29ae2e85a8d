// `typodont devices`: lists connected devices, who may open them, and the command that adds missing permissions.
#include "haptics/devices.h"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/base/log.h"

namespace typodont {

namespace {

constexpr const char* kRulesFolder = "/etc/udev/rules.d";

struct DevicesOptions {
  bool json = false;
  std::string install;
};

void print_json(const std::vector<haptics::FoundDevice>& found) {
  nlohmann::ordered_json out;
  out["devices"] = nlohmann::json::array();
  for (const auto& d : found) {
    nlohmann::ordered_json device{{"address", d.address},     {"kind", d.kind}, {"model", d.model},
                                  {"serial", d.serial},       {"node", d.node}, {"force_limit_N", d.force_limit},
                                  {"permitted", d.permitted}, {"mend", d.mend}};
    out["devices"].push_back(device);
  }
  out["addresses"] = nlohmann::json::array();
  for (const auto& driver : haptics::drivers()) {
    out["addresses"].push_back({{"address", driver.scheme + ":" + driver.rest}, {"about", driver.about}});
  }
  fmt::print("{}\n", out.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

void print_text(const std::vector<haptics::FoundDevice>& found) {
  if (found.empty()) fmt::print("No devices are plugged in.\n");
  for (const auto& d : found) {
    fmt::print("{}\n", d.address.empty() ? d.node : d.address);
    fmt::print("    {}, {}", d.model, d.kind);
    if (!d.serial.empty()) fmt::print(", serial {}", d.serial);
    if (d.force_limit > 0) fmt::print(", up to {:g} N", d.force_limit);
    if (!d.node.empty() && !d.address.empty()) fmt::print(", {}", d.node);
    fmt::print("\n");
    if (!d.permitted) fmt::print("    no permission to open it; remedy: {}\n", d.mend);
  }
  fmt::print("\nAddresses that --hand takes:\n");
  for (const auto& driver : haptics::drivers()) {
    fmt::print("    {:<42} {}\n", driver.scheme + ":" + driver.rest, driver.about);
  }
}

void run(const DevicesOptions& options) {
  if (options.install.empty()) {
    const auto found = haptics::list_devices();
    options.json ? print_json(found) : print_text(found);
    return;
  }
  const auto file = haptics::install_udev_rules(options.install);
  if (options.install == kRulesFolder) {
    const int status = std::system(
        "udevadm control --reload >/dev/null 2>&1 && "
        "udevadm trigger --subsystem-match=hidraw --subsystem-match=tty --subsystem-match=usb --subsystem-match=input "
        ">/dev/null 2>&1");
    if (status != 0) log::warn("udev did not reload its rules; plug the devices in again, or restart the computer");
  }
  if (options.json) {
    fmt::print("{}\n", nlohmann::json{{"installed", file.string()}}.dump());
  } else {
    fmt::print("{}\n", file.string());
  }
}

}  // namespace

void add_devices_command(cli::Command& app) {
  auto* command = app.add_command("devices", "List haptic devices, 6-DoF mice and pedals, and how to make each usable");
  command->footer(
      "Examples:\n"
      "  typodont devices\n"
      "  typodont devices --json\n"
      "  sudo typodont devices --install-udev     let the user at the console open them");
  auto options = std::make_shared<DevicesOptions>();
  command->add_flag("--json", options->json, "For machines");
  command->add_option("--install-udev", options->install, "Write the udev rules, here or into a folder")
      ->optional_word(kRulesFolder, "[FOLDER]");
  command->callback([options] { run(*options); });
}

}  // namespace typodont
