#include "server/matching/pairs/matcher.h"
