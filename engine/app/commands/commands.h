// The program's commands: one file each, named as the user types it.
#pragma once

namespace CLI {
class App;
}

namespace typodont {

// Each adds its subcommand to `app`; the work runs in the subcommand's callback. It throws Error (exit 2) or
// RunFailure (exit 1), prints results on standard output and messages on standard error.
void add_bench_command(CLI::App& app);
void add_calibrate_command(CLI::App& app);
void add_demo_command(CLI::App& app);
void add_devices_command(CLI::App& app);
void add_doctor_command(CLI::App& app);
void add_import_command(CLI::App& app);
void add_mesh_command(CLI::App& app);
void add_pack_command(CLI::App& app);
void add_render_command(CLI::App& app);
void add_replay_command(CLI::App& app);
void add_report_command(CLI::App& app);
void add_run_command(CLI::App& app);
void add_servo_command(CLI::App& app);
void add_sound_command(CLI::App& app);

}  // namespace typodont
