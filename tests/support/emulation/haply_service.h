// Emulates the Haply service, with Boost.Beast, as a state machine over bytes for a simulated link or a real socket.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "engine/base/pose.h"

namespace typodont::test {

class HaplyService {
 public:
  HaplyService();
  ~HaplyService();
  /// Takes bytes from the client and returns bytes for the client.
  std::string feed(const std::string& bytes);
  /// Returns a text frame of the server, divided into `fragments` parts.
  static std::string frame(const std::string& text, int fragments = 1, std::uint8_t opcode = 1);
  std::string state_text() const;

  dvec3 position{0.01, 0.02, 0.03};  // m
  bool button = false;
  dvec3 force{0};  // N, last commanded force
  int forces = 0;  // number of force commands
  int pongs = 0;
  bool open = false;
  int fragments = 1;  // number of frames of the next state

 private:
  void receive();
  void send_state();

  struct Connection;
  std::unique_ptr<Connection> connection_;
};

}  // namespace typodont::test
