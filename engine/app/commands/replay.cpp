// typodont replay: runs a recorded session again and says whether it comes out the same.
#include "engine/app/replay.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/app/commands/commands.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/progress.h"

namespace typodont {

namespace {

struct Options {
  std::string session;
  bool check = false, json = false;
};

void run(const Options& options) {
  ReplayResult result;
  {
    Progress progress("replay");
    result = replay_session(options.session, [&](double done) { progress.at(done); });
  }
  if (options.json) {
    const nlohmann::ordered_json json = {{"identical", result.identical},   {"seconds", result.seconds},
                                         {"ticks", result.ticks},           {"field_hash", result.field_hash},
                                         {"force_hash", result.force_hash}, {"faults", result.ticks_with_faults},
                                         {"truncated", result.truncated}};
    fmt::print("{}\n", json.dump());
  } else {
    fmt::print("{}: {} ticks, {:.3f} s{}\n", options.session, result.ticks, result.seconds,
               result.truncated ? ", cut off" : "");
    fmt::print("forces {}, tissue {}\n", result.force_hash, result.field_hash);
    fmt::print("{}\n",
               result.identical ? "identical to the recording" : "differs from the recording: " + result.what_differs);
  }
  if (options.check && !result.identical) throw RunFailure("the replay differs: " + result.what_differs);
}

}  // namespace

void add_replay_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("replay", "Run a recorded session again, bit for bit");
  command->footer("Example:\n  typodont replay demo/session.h5 --check --json");
  command->add_option("session", options->session, "recorded session (.h5)")->required();
  command->add_flag("--check", options->check, "exit 1 where the replay differs from the recording");
  command->add_flag("--json", options->json, "print the result as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace typodont
