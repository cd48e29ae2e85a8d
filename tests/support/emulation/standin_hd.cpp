// Replaces 3D Systems' libHD.so in tests: the same C interface with two arms ("Default Device" and "Second") without
// hardware, and one scheduler for both, which advances only on request of the test.
#include <cstring>

namespace {

constexpr unsigned int kArms = 2;
double transform[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
double force[kArms + 1][3] = {};  // by handle; 0 is no device
int buttons = 0;
unsigned int error = 0, current = 0;
bool output_enabled[kArms + 1] = {}, initialised[kArms + 1] = {}, running = false;
struct Task {
  unsigned int (*callback)(void*) = nullptr;
  void* data = nullptr;
};
Task tasks[kArms];

struct ErrorInfo {
  unsigned int code;
  int internal;
  unsigned int device;
};

}  // namespace

extern "C" {

// The interface.
unsigned int hdInitDevice(const char* name) {
  const bool second = name && std::strcmp(name, "Second") == 0;
  if (name && !second && std::strcmp(name, "Default Device") != 0) return 0xFFFFFFFF;
  current = second ? 2 : 1;
  initialised[current] = true;
  return current;
}
void hdDisableDevice(unsigned int device) {
  initialised[device] = false;
}
void hdMakeCurrentDevice(unsigned int device) {
  current = device;
}
void hdBeginFrame(unsigned int device) {
  current = device;
}
void hdEndFrame(unsigned int) {}
void hdGetDoublev(unsigned int what, double* out) {
  if (what == 0x2052) std::memcpy(out, transform, sizeof transform);
  if (what == 0x2100) out[0] = 0.1, out[1] = 0.2, out[2] = 0.3;
  if (what == 0x2150) out[0] = 0.4, out[1] = 0.5, out[2] = 0.6;
  if (what == 0x2602) *out = 0.4;   // N/mm
  if (what == 0x2603) *out = 3.3;   // N
  if (what == 0x2604) *out = 0.88;  // N
}
void hdGetIntegerv(unsigned int what, int* out) {
  if (what == 0x2000) *out = buttons;
}
const char* hdGetString(unsigned int what) {
  if (!initialised[current]) return nullptr;
  return what == 0x2501 ? "Touch (stand-in)" : "S-0001";
}
void hdSetDoublev(unsigned int what, const double* value) {
  if (what == 0x2700) std::memcpy(force[current], value, sizeof force[current]);
}
void hdEnable(unsigned int what) {
  if (what == 0x4000) output_enabled[current] = true;
}
void hdDisable(unsigned int what) {
  if (what == 0x4000) output_enabled[current] = false;
}
ErrorInfo hdGetError() {
  const ErrorInfo info{error, 0, 1};
  error = 0;
  return info;
}
void hdStartScheduler() {
  running = true;
}
void hdStopScheduler() {
  running = false;
}
unsigned long hdScheduleAsynchronous(unsigned int (*f)(void*), void* data, unsigned short) {
  for (unsigned long i = 0; i < kArms; ++i) {
    if (tasks[i].callback) continue;
    tasks[i] = {f, data};
    return i + 7;
  }
  return 0;
}
void hdUnschedule(unsigned long handle) {
  tasks[handle - 7] = {};
}

// For the test.
void standin_hd_place(double x, double y, double z) {
  transform[12] = x, transform[13] = y, transform[14] = z;
}
void standin_hd_press(int mask) {
  buttons = mask;
}
void standin_hd_fail(unsigned int code) {
  error = code;
}
// Runs one turn of the scheduler. Returns false if nothing is scheduled.
bool standin_hd_step() {
  if (!running) return false;
  bool any = false;
  for (Task& task : tasks) {
    if (task.callback && task.callback(task.data) == 0) task = {};
    any |= task.callback != nullptr;
  }
  return any;
}
const double* standin_hd_force() {
  return force[1];
}
const double* standin_hd_second_force() {
  return force[2];
}
bool standin_hd_output() {
  return output_enabled[1] && initialised[1];
}
}
