// Stands in for 3D Systems' libHD.so in tests: the same C interface, no hardware, and its scheduler runs only when the
// test says so.
#include <cstring>

namespace {

double transform[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
double force[3] = {0, 0, 0};
int buttons = 0;
unsigned int error = 0;
bool output_enabled = false, initialised = false;
unsigned int (*callback)(void*) = nullptr;
void* callback_data = nullptr;

struct ErrorInfo {
  unsigned int code;
  int internal;
  unsigned int device;
};

}  // namespace

extern "C" {

// The interface.
unsigned int hdInitDevice(const char* name) {
  if (name && std::strcmp(name, "Default Device") != 0) return 0xFFFFFFFF;
  initialised = true;
  return 1;
}
void hdDisableDevice(unsigned int) {
  initialised = false;
}
void hdMakeCurrentDevice(unsigned int) {}
void hdBeginFrame(unsigned int) {}
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
  if (!initialised) return nullptr;
  return what == 0x2501 ? "Touch (stand-in)" : "S-0001";
}
void hdSetDoublev(unsigned int what, const double* value) {
  if (what == 0x2700) std::memcpy(force, value, sizeof force);
}
void hdEnable(unsigned int what) {
  if (what == 0x4000) output_enabled = true;
}
void hdDisable(unsigned int what) {
  if (what == 0x4000) output_enabled = false;
}
ErrorInfo hdGetError() {
  const ErrorInfo info{error, 0, 1};
  error = 0;
  return info;
}
void hdStartScheduler() {}
void hdStopScheduler() {}
unsigned long hdScheduleAsynchronous(unsigned int (*f)(void*), void* data, unsigned short) {
  callback = f;
  callback_data = data;
  return 7;
}
void hdUnschedule(unsigned long) {
  callback = nullptr;
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
bool standin_hd_step() {
  if (!callback) return false;
  if (callback(callback_data) == 0) callback = nullptr;
  return callback != nullptr;
}
const double* standin_hd_force() {
  return force;
}
bool standin_hd_output() {
  return output_enabled && initialised;
}
}
