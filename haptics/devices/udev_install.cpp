#include <unistd.h>

#include "engine/base/error.h"
#include "engine/base/json.h"
#include "haptics/devices.h"

namespace typodont::haptics {

std::filesystem::path install_udev_rules(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "70-typodont.rules";
  std::error_code none;
  if (!std::filesystem::is_directory(folder, none)) {
    throw Error(folder.string(), "", "no such folder", "the folder of udev's rules");
  }
  if (::access(folder.c_str(), W_OK) != 0) {
    throw Error(file.string(), "", "no permission to write it", "root; run: sudo typodont devices --install-udev");
  }
  write_file_atomically(file, udev_rules());
  return file;
}

}  // namespace typodont::haptics
