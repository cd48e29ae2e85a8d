#include "haptics/devices/fd_link.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <utility>

#include "engine/base/error.h"

namespace typodont::haptics {

Descriptor::~Descriptor() {
  if (fd_ >= 0) ::close(fd_);
}

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

namespace {

class FdLink : public Link {
 public:
  /// `whole`: each write is one message, so that another process may write too.
  FdLink(Descriptor fd, bool whole) : fd_(std::move(fd)), whole_(whole) {
    ::fcntl(fd_.get(), F_SETFL, ::fcntl(fd_.get(), F_GETFL) | O_NONBLOCK);
  }

  int read(std::span<std::uint8_t> buffer, Nanos timeout) noexcept override {
    pollfd waiting{fd_.get(), POLLIN, 0};
    const timespec time{timeout / kNanosPerSecond, timeout % kNanosPerSecond};
    const int ready = ::ppoll(&waiting, 1, &time, nullptr);
    if (ready == 0 || (ready < 0 && errno == EINTR)) return 0;
    if (ready < 0) return -1;
    const ssize_t n = ::read(fd_.get(), buffer.data(), buffer.size());
    if (n > 0) return static_cast<int>(n);
    // If the descriptor is ready to read but delivers no bytes, the connection is closed.
    return n < 0 && (errno == EAGAIN || errno == EINTR) ? 0 : -1;
  }

  bool write(std::span<const std::uint8_t> bytes) noexcept override {
    const int kept = errno;  // signal handlers must not change errno
    // send() without SIGPIPE; write() if the descriptor is not a socket.
    ssize_t n = ::send(fd_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n < 0 && errno == ENOTSOCK) n = ::write(fd_.get(), bytes.data(), bytes.size());
    errno = kept;
    return n == static_cast<ssize_t>(bytes.size());
  }
  int descriptor() const noexcept override { return whole_ ? fd_.get() : -1; }

 private:
  Descriptor fd_;
  bool whole_;
};

}  // namespace

Descriptor open_exclusively(const std::filesystem::path& node) {
  Descriptor fd(::open(node.c_str(), O_RDWR | O_CLOEXEC | O_NOCTTY | O_NONBLOCK));
  if (fd.get() < 0) {
    if (errno == EACCES || errno == EPERM) {
      throw Error(node.string(), "", "no permission to open it",
                  fmt::format("access; mend it by: {}", kPermissionRemedy));
    }
    throw Error(node.string(), "", std::strerror(errno), "a device that is plugged in");
  }
  if (::flock(fd.get(), LOCK_EX | LOCK_NB) != 0) {
    throw Error(node.string(), "", "another program holds this device", "a device that is free");
  }
  return fd;
}

Descriptor claim(const std::string& name, const std::string& where) {
  Descriptor fd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string whole = "typodont/" + name;  // name of an abstract socket, which leaves no file
  whole.copy(address.sun_path + 1, sizeof address.sun_path - 1);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + whole.size());
  if (fd.get() < 0 || ::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), size) != 0) {
    throw Error(where, "", errno == EADDRINUSE ? "another program holds this device" : std::strerror(errno),
                "a device that is free");
  }
  return fd;
}

std::unique_ptr<Link> link_over(Descriptor fd) {
  return std::make_unique<FdLink>(std::move(fd), false);
}

std::unique_ptr<Link> open_serial(const std::filesystem::path& port) {
  Descriptor fd = open_exclusively(port);
  termios settings{};
  if (::tcgetattr(fd.get(), &settings) != 0) throw Error(port.string(), "", "not a serial port", "a serial port");
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 0;
  if (::tcsetattr(fd.get(), TCSANOW, &settings) != 0) throw Error(port.string(), "", std::strerror(errno), "raw mode");
  ::ioctl(fd.get(), TIOCEXCL);  // also prevents access by programs that ignore locks
  ::tcflush(fd.get(), TCIOFLUSH);
  return std::make_unique<FdLink>(std::move(fd), true);
}

std::unique_ptr<Link> connect_tcp(const std::string& host, int port) {
  const std::string where = fmt::format("{}:{}", host, port);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found) != 0) {
    throw Error(where, "", "no such host", "a service that listens there");
  }
  Descriptor fd;
  int error = ECONNREFUSED;
  for (const addrinfo* a = found; a; a = a->ai_next) {
    Descriptor attempt(::socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC, a->ai_protocol));
    if (attempt.get() >= 0 && ::connect(attempt.get(), a->ai_addr, a->ai_addrlen) == 0) {
      fd = std::move(attempt);
      break;
    }
    error = errno;
  }
  ::freeaddrinfo(found);
  if (fd.get() < 0) throw Error(where, "", std::strerror(error), "a service that listens there");
  const int on = 1;
  ::setsockopt(fd.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  return std::make_unique<FdLink>(std::move(fd), true);
}

}  // namespace typodont::haptics
