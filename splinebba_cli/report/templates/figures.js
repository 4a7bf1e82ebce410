"use strict";
// Figures that can be enlarged and asked.
