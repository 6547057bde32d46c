// Okabe & Ito, "Color Universal Design" (2008): told apart with every kind of colour vision.

export const ORANGE = '#e69f00';
export const SKY = '#56b4e9';
export const GREEN = '#009e73';
export const YELLOW = '#f0e442';
export const BLUE = '#0072b2';
export const VERMILLION = '#d55e00';
export const PURPLE = '#cc79a7';

/** Of the fixed and of the moving body. */
export const BODIES = ['#a9b4c0', SKY];
export const CONTACTS = [VERMILLION, YELLOW];
export const BOXES = [GREEN, BLUE];
export const CURVE = PURPLE;
export const CLEARANCE = GREEN;
export const PENETRATION = ORANGE;
export const ALONG = GREEN;
export const IMPACT = BLUE;
export const PICKED = PURPLE;

const WORKERS = [ORANGE, SKY, GREEN, YELLOW, BLUE, VERMILLION, PURPLE];
export const worker = (number) => WORKERS[number % WORKERS.length];
export const NO_WORKER = '#d0d0d0';
export const SEVERAL_WORKERS = '#5b5b5b';
