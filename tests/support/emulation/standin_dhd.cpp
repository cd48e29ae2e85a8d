// Replaces Force Dimension's libdhd.so.3 in tests: the same C interface without hardware.
#include <cstring>

namespace {
double place[3] = {0, 0, 0};
double wrench[6] = {0, 0, 0, 0, 0, 0};
unsigned int buttons = 0;
unsigned char watchdog = 0;
bool broken = false, force_on = false, is_open = false;
int opened = 0;
}  // namespace

extern "C" {

// The interface.
int dhdGetDeviceCount() {
  return 1;
}
int dhdOpenID(char id) {
  if (id != 0 || is_open) return -1;
  is_open = true;
  ++opened;
  return 0;
}
int dhdOpenSerial(int serial) {
  return serial == 4711 ? dhdOpenID(0) : -1;
}
const char* dhdErrorGetLastStr() {
  return "";
}
int dhdClose(char) {
  is_open = false;
  return 0;
}
int dhdEnableForce(unsigned char on, char) {
  force_on = on != 0;
  return 0;
}
int dhdGetPosition(double* x, double* y, double* z, char) {
  if (broken) return -1;
  *x = place[0], *y = place[1], *z = place[2];
  return 0;
}
int dhdGetOrientationFrame(double R[3][3], char) {  // a rotation of 90° about z
  const double turn[3][3] = {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}};
  std::memcpy(R, turn, sizeof turn);
  return broken ? -1 : 0;
}
unsigned int dhdGetButtonMask(char) {
  return buttons;
}
int dhdSetForceAndTorque(double fx, double fy, double fz, double tx, double ty, double tz, char) {
  const double w[6] = {fx, fy, fz, tx, ty, tz};
  std::memcpy(wrench, w, sizeof wrench);
  return 0;
}
int dhdSetWatchdog(unsigned char periods, char) {
  watchdog = periods;
  return 0;
}
const char* dhdGetSystemName(char) {
  if (!is_open) return "";  // known only while it is open
  return "sigma.7 (stand-in)";
}
int dhdGetJointAngles(double* out, char) {
  for (int i = 0; i < 8; ++i) out[i] = 0.1 * (i + 1);
  return broken ? -1 : 0;
}
bool dhdHasWrist(char) {
  return true;
}
int dhdGetSerialNumber(unsigned short* out, char) {
  if (!is_open) return -1;
  *out = 4711;
  return 0;
}

// For the test.
void standin_dhd_place(double x, double y, double z) {
  place[0] = x, place[1] = y, place[2] = z;
}
void standin_dhd_break(bool on) {
  broken = on;
}
int standin_dhd_opened() {
  return opened;
}
void standin_dhd_press(unsigned int mask) {
  buttons = mask;
}
const double* standin_dhd_wrench() {
  return wrench;
}
bool standin_dhd_powered() {
  return force_on && is_open;
}
unsigned char standin_dhd_watchdog() {
  return watchdog;
}
}
