// Links over file descriptors (serial ports, TCP), and locks that prevent other programs from using a device.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "haptics/devices/link.h"

namespace typodont::haptics {

/// Owns an open file descriptor and closes it.
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

/// Opens a device node for reading and writing. While it is open, it is locked against other programs (flock). Throws
/// an Error that names the node and the reason: it is missing, permission is missing (with the command that grants it),
/// or another program uses the node.
Descriptor open_exclusively(const std::filesystem::path& node);

/// Locks a device that has no node of its own, for example a device behind a service. Only one program on this computer
/// can have the lock `name` at a time. The lock ends when the descriptor is closed. Throws an Error that names `where`.
Descriptor claim(const std::string& name, const std::string& where);

/// Opens a serial port in raw mode. Throws Error.
std::unique_ptr<Link> open_serial(const std::filesystem::path& port);
/// Connects to a TCP server, for protocols that send each message with one write(). Throws Error if no server listens.
std::unique_ptr<Link> connect_tcp(const std::string& host, int port);
/// Makes a link of an open stream descriptor (a pseudo-terminal or a socket), and takes ownership of the descriptor.
std::unique_ptr<Link> link_over(Descriptor fd);

/// The command that grants access to devices, for error messages.
inline constexpr const char* kPermissionRemedy = "sudo typodont devices --install-udev, then plug the device in again";

}  // namespace typodont::haptics
