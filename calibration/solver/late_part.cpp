// The shared object typodont-calibration.so exports only this variable.
#include "calibration/solver/late_part.h"

using namespace typodont::calibration;

const LatePart typodont_calibration_part{
    &project,
    &solve_camera,
    &solve_hand_eye,
#ifdef TYPODONT_CAMERA
    &find_board,
#endif
};
