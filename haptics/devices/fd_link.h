// Links over file descriptors (serial ports, TCP), and the lock that excludes a second program from a device.
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

/// Opens a device node for reading and writing, and locks it (flock) while it is open. Throws Error naming the node:
/// missing, no permission (with the command that fixes it), or in use by another program.
Descriptor open_exclusively(const std::filesystem::path& node);

/// A lock for a device without a node of its own, for example a device behind a service. Only one program on this
/// computer can hold the name at a time, until the descriptor is closed. Throws Error naming `where`.
Descriptor claim(const std::string& name, const std::string& where);

/// A serial port in raw mode. Throws Error.
std::unique_ptr<Link> open_serial(const std::filesystem::path& port);
/// Connects to a TCP server, for protocols that send each message by one write(). Throws Error if nobody listens.
std::unique_ptr<Link> connect_tcp(const std::string& host, int port);
/// Takes ownership of a stream descriptor (a pseudo-terminal or a socket).
std::unique_ptr<Link> link_over(Descriptor fd);

/// The command that grants a missing permission.
inline constexpr const char* kPermissionRemedy = "sudo typodont devices --install-udev, then plug the device in again";

}  // namespace typodont::haptics
