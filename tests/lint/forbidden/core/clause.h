// What a bad header opens with.
#pragma once
