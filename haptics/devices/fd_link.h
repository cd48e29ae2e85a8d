// Serial and TCP links to devices, and locks that keep other programs from using them.
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

/// Opens a device node and locks it (flock). Throws Error with node and reason: missing, no permission (with the
/// remedy), or in use.
Descriptor open_exclusively(const std::filesystem::path& node);

/// Locks a device that has no node: only one program can hold `name`, until the descriptor is closed. Throws Error;
/// `where`: place that its message states.
Descriptor claim(const std::string& name, const std::string& where);

/// Opens a serial port in raw mode. Throws Error.
std::unique_ptr<Link> open_serial(const std::filesystem::path& port);
/// Connects to a TCP port. One write() sends one message. Throws Error.
std::unique_ptr<Link> connect_tcp(const std::string& host, int port);
/// Makes a link of a stream (pseudo-terminal, socket), and takes ownership of it.
std::unique_ptr<Link> link_over(Descriptor fd);

/// The command that grants access to devices, for error messages.
inline constexpr const char* kPermissionRemedy = "sudo typodont devices --install-udev, then plug the device in again";

}  // namespace typodont::haptics
