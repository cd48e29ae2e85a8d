// `typodont sign`: signs recorded sessions with a school's own key.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/session/session_file.h"
#include "engine/session/signature.h"

namespace typodont {

namespace {

struct SignOptions {
  std::vector<std::string> sessions;
  std::string key, new_key;
};

void sign(const SignOptions& options) {
  if (!options.new_key.empty()) {
    if (!options.key.empty() || !options.sessions.empty())
      throw Error("sign", "", "--new-key with a session or --key", "--new-key FILE alone");
    session::make_key(options.new_key);
    fmt::print("{}: key {}; who has this file can sign: keep it secret, and keep a copy\n", options.new_key,
               session::load_key(options.new_key).id());
    return;
  }
  if (options.key.empty() || options.sessions.empty())
    throw Error("sign", "", "no key or no session", "--key FILE SESSION.h5 …, or --new-key FILE");
  const session::SigningKey key = session::load_key(options.key);
  std::vector<session::OpenedSession> sessions;
  for (const std::string& file : options.sessions) {
    sessions.emplace_back(file);
    sessions.back().bytes();  // reads all bytes, so that the bytes that are checked are the bytes that are signed
    if (session::SessionReader(sessions.back()).truncated())
      throw Error(file, "", "a session that was cut off", "one that ended");
  }
  for (const session::OpenedSession& session : sessions) {
    fmt::print("{}: signed with key {}\n", session::sign_session(session, key).string(), key.id());
  }
}

}  // namespace

void add_sign_command(cli::Command& app) {
  auto options = std::make_shared<SignOptions>();
  cli::Command* command = app.add_command("sign", "Sign recorded sessions with a school's key");
  command->footer(
      "replay --check --key FILE and report --key FILE verify it.\n"
      "Example:\n  typodont sign --new-key school.key\n  typodont sign --key school.key session.h5\n"
      "  typodont replay session.h5 --check --key school.key");
  command->add_option("sessions", options->sessions, "recorded sessions (.h5); SESSION.h5.sig is written beside each");
  command->add_option("--key", options->key, "the key's file");
  command->add_option("--new-key", options->new_key, "make a key and write it to this new file");
  command->callback([options] { sign(*options); });
}

}  // namespace typodont
