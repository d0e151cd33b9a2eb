#include "server/matching/matcher.h"
