// The commands of the program. Each command has a file with its name, in which hyphens are replaced by underscores.
#pragma once

namespace typodont {

namespace cli {
class Command;
}

// Each function adds a command to `program`. When the command runs, it prints results on standard output and messages
// on standard error. It throws Error (exit status 2) or RunFailure (exit status 1).
void add_calibrate_command(cli::Command& program);
void add_demo_command(cli::Command& program);
void add_devices_command(cli::Command& program);
void add_doctor_command(cli::Command& program);
void add_experiment_command(cli::Command& program);
void add_fit_material_command(cli::Command& program);
void add_fuse_command(cli::Command& program);
void add_import_command(cli::Command& program);
void add_mesh_command(cli::Command& program);
void add_next_command(cli::Command& program);
void add_fit_damping_command(cli::Command& program);
void add_pack_command(cli::Command& program);
void add_plan_command(cli::Command& program);
void add_case_command(cli::Command& program);
void add_volume_command(cli::Command& program);
void add_render_command(cli::Command& program);
void add_replay_command(cli::Command& program);
void add_remark_command(cli::Command& program);
void add_report_command(cli::Command& program);
void add_rig_command(cli::Command& program);
void add_run_command(cli::Command& program);
void add_schema_command(cli::Command& program);
void add_servo_command(cli::Command& program);
void add_repair_command(cli::Command& program);
void add_rescore_command(cli::Command& program);
void add_sign_command(cli::Command& program);
void add_sound_command(cli::Command& program);

}  // namespace typodont
