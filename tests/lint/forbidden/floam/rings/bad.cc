#include "floam/track/tracker.h"
