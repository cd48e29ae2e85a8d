// typodont: reads the command line, runs one command, turns errors into messages and exit statuses.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "engine/app/commands/commands.h"
#include "engine/app/hands/hands.h"
#ifdef TYPODONT_WINDOW
#include "engine/app/operator/operator.h"
#endif
#include "engine/app/hands/replay_hand.h"
#include "engine/base/cache.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/gpu/driver_cache.h"

int main(int argc, char** argv) {
  using namespace typodont;
  CLI::App app("Typodont: a co-located visual, haptic and audio workbench for hand-eye training on hard tissue",
               "typodont");
  app.set_version_flag("--version", TYPODONT_VERSION);
  app.require_subcommand(0, 1);  // after the first, words are arguments: `bench render` is not the command `render`
  add_demo_command(app);
  add_servo_command(app);
  add_import_command(app);
  add_mesh_command(app);
  add_pack_command(app);
  add_render_command(app);
  add_report_command(app);
  add_devices_command(app);
  add_doctor_command(app);
  add_sound_command(app);
  add_calibrate_command(app);
  add_replay_command(app);
  add_run_command(app);
  add_bench_command(app);
  add_replay_driver();
  add_window_drivers();
  if (const auto kept = cache::folder(); !kept.empty()) gpu::keep_driver_cache(kept / "driver");
  try {
    if (argc == 1) {
      try {
#ifdef TYPODONT_WINDOW
        run_operator();
        return 0;
#else
        throw Error("this build", "", "no window support", "a build with TYPODONT_WINDOW=ON");
#endif
      } catch (const Error& e) {
        log::error("The operator's window cannot be opened: {}", e.what());
        std::fputs(app.help().c_str(), stderr);
        return 2;
      }
    }
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::Success& e) {  // --help, --version
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    app.exit(e);
    return 2;
  } catch (const Error& e) {
    log::error("{}", e.what());
    return 2;
  } catch (const std::exception& e) {
    log::error("{}", e.what());
    return 1;
  }
}
