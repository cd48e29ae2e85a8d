// Links over file descriptors: serial ports, TCP, and the lock that keeps a second program away from a device.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "haptics/devices/link.h"

namespace typodont::haptics {

/// An open file descriptor.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor();
  Descriptor(Descriptor&& other) noexcept : fd_(other.fd_) { other.fd_ = -1; }
  Descriptor& operator=(Descriptor&& other) noexcept;
  int get() const noexcept { return fd_; }

 private:
  int fd_ = -1;
};

/// Opens a device node for reading and writing and locks it (flock) for as long as it stays open. Throws Error naming
/// the node: absent, no permission (with the command that mends it), or in use by another program.
Descriptor open_exclusively(const std::filesystem::path& node);

/// The same for a device that has no node, only a service: a name that one program on this computer can hold at a time,
/// for as long as the descriptor is open. Throws Error naming `where`.
Descriptor claim(const std::string& name, const std::string& where);

/// A serial port in raw mode. Throws Error.
std::unique_ptr<Link> open_serial(const std::filesystem::path& port);
/// For protocols whose every message is one write(). Throws Error when nobody listens.
std::unique_ptr<Link> connect_tcp(const std::string& host, int port);
/// Takes over any stream descriptor (a pseudo terminal's end, a socket).
std::unique_ptr<Link> link_over(Descriptor fd);

/// The command that mends a missing permission.
inline constexpr const char* kMendPermission = "sudo typodont devices --install-udev, then plug the device in again";

}  // namespace typodont::haptics
